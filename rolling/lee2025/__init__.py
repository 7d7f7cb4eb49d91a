"""The study of Lee, Kim & Kim (2025): readings solved, statements judged, figures drawn.

- `study`: readings and cases; `reproduce`: the command.
- `measures`, `trends`, `bounds`, `twins`, `checks`, `grid_error`: numbers of cases, and verdicts
  from them.
- `statements`, `claims`, `standing`, `results`: the article's statements, judged under each
  reading.
- `figure_data`, `figure_layout`, `curves`, `surfaces_3d`, `figures`: the article's figures.
- `claims_text`, `page`: claims.md, tables.md and index.html.
"""
