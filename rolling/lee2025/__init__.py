"""An article's study run anew: its readings solved, its statements judged, its figures drawn.

Data flows study -> measures -> verdicts, twins -> claims -> standing, claims_text, and study -> readings -> figures -> page;
reproduce runs it all.
"""
