"""Makes the workbooks from good/plain/runs.csv. Needs openpyxl (made with 3.1.5): python workbooks.py"""

import datetime
import shutil
from pathlib import Path

import openpyxl

HERE = Path(__file__).parent
SCENE = (HERE / "good" / "plain" / "scene.toml").read_text()
HEADER, *ROWS = [line.split(",") for line in (HERE / "good" / "plain" / "runs.csv").read_text().split()]


def number(cell):
    try:
        return float(cell)
    except ValueError:
        return cell or None


def write(case, sheets, runs="runs.xlsx", data=""):
    folder = HERE / case
    folder.mkdir(exist_ok=True)
    (folder / "scene.toml").write_text(SCENE.replace('"runs.csv"\n', f'"{runs}"\n{data}'))
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for at, row in enumerate(rows, 1):
            for column, cell in enumerate(row, 1):
                if cell is not None:
                    sheet.cell(at, column, cell)
    book.save(folder / "runs.xlsx")


numbers = [HEADER] + [[number(cell) for cell in row] for row in ROWS]
write("good/workbook", {"Sheet1": numbers, "notes": [["not", "runs"]]})
# numbers that mark a run that stuck and a cell that is missing
mark = {(4, None): -999.0, (6, 0.0): -1.0}
marked = [[mark.get((at, cell), cell) for at, cell in enumerate(row)] for row in numbers]
marks = 'values.restitution = { "-1" = "0" }\nvalues.film_ratio = { "-999" = "NA" }\n'
write("good/workbook_with_marks", {"Sheet1": marked}, data=marks)
# as text, with decimal commas, an empty row and one of blanks, on a sheet that is not the first
texts = [HEADER] + [[cell.replace(".", ",") or None for cell in row] for row in ROWS]
write(
    "good/workbook_of_texts",
    {"Deckblatt": [["Versuche"]], "Läufe": texts[:5] + [[None] * 7, [" "] * 7] + texts[5:]},
    "runs.xlsx#Läufe",
)
write(
    "bad/workbook_bad_cells",
    {
        "Sheet1": [
            HEADER,
            ["PTFE", "dry", 4, None, None, 0.5, "high"],
            ["PTFA", "AK10", 4, 240, 0.06, 0.5, 0.6],
            [],
            ["PTFE", "AK10", 4, 240, 0.06, datetime.date(2026, 5, 1), 0.6],
            ["PTFE", "AK10", 4, 240, 0.06, 0.5, "#DIV/0!"],
            ["PTFE", "AK10", 4, 240, 0.06, 0.5, None],
            ["PTFE", "AK10", 4, 240, 0.06, "0,5", "0.6"],
        ]
    },
)
write("bad/workbook_unknown_sheet", {"Runs": numbers, "Notes": [["x"]]}, "runs.xlsx#Run")
write("bad/workbook_empty_sheet", {"Sheet1": []})
write("bad/workbook_is_none", {"Sheet1": numbers})
shutil.copy(HERE / "good" / "plain" / "runs.csv", HERE / "bad" / "workbook_is_none" / "runs.xlsx")
