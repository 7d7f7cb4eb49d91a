"""An article's study run anew: its readings solved, its statements judged, its figures drawn.

Data flows study -> measures -> verdicts -> claims -> claims_text, and study -> readings -> figures -> page; reproduce runs it all.
"""
