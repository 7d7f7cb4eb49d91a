"""Bearings that turn: their rough contacts, solving, results, figures and page."""
