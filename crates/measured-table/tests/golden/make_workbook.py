"""Makes gel.xlsx, as a rheometer writes it: two sheets, a preamble, a cell far off, dates and a duration. Needs openpyxl."""
from datetime import datetime, timedelta
from pathlib import Path

from openpyxl import Workbook

book = Workbook()
sheet = book.active
sheet.title = "Relaxation"
sheet["B1"] = "Sample:\tgel\nof today"
for row, cells in enumerate([("Time", "Relaxation modulus"), ("s", "kPa"), (0.5, 4), (1, 2.5), (2, 1.25), (4, 1)], start=3):
    for column, cell in enumerate(cells, start=2):
        sheet.cell(row, column, cell)
clock = book.create_sheet("Clock")
clock.append(["time of day", "date", "elapsed", "force (N)", "position (mm)"])
for n in range(4):
    at = datetime(2026, 3, 1, 9, 59, 59) + timedelta(seconds=n)
    clock.append([at.time(), at, timedelta(hours=3, seconds=n), n / 4, n])
    clock.cell(n + 2, 3).number_format = "[h]:mm:ss"
book.create_chartsheet("A picture")
book.save(Path(__file__).with_name("gel.xlsx"))
