"""Makes examples of good/plain/runs.csv as other programs write it, and with other columns: python dialects.py

The bytes are those that the programs document, not their own: Excel separates by the list separator of the system's region
(semicolons and decimal commas in a German one), ends lines with CR LF, and puts a byte-order mark before "CSV UTF-8" only;
its "Text (Tab delimited)" has tabs. Below a table whose rows were cleared it writes lines of separators. Google Sheets
separates by commas, quotes what has one, ends lines with CR LF and leaves the last line without an end. What LibreOffice
writes it wrote itself (libreoffice.py).
"""

from pathlib import Path

HERE = Path(__file__).parent / "good"
G = 9.81
DENSITY, VISCOSITY = 2150, 9.3e-3

SCENE = (HERE / "plain" / "scene.toml").read_text()
HEADER, *ROWS = [line.split(",") for line in (HERE / "plain" / "runs.csv").read_text().split()]


def german(cell):
    return cell.replace(".", ",")


def write(case, text, data=""):
    folder = HERE / case
    folder.mkdir(exist_ok=True)
    (folder / "runs.csv").write_bytes(text.encode())
    (folder / "scene.toml").write_text(SCENE.replace('runs = "runs.csv"\n', 'runs = "runs.csv"\n' + data))


def table(rows, separator=",", end="\n", quoted=lambda cell: cell):
    return "".join(separator.join(map(quoted, row)) + end for row in rows)


def changed(header, row_of):
    return [header] + [row_of(dict(zip(HEADER, row))) for row in ROWS]


def number(value):
    return repr(value)


all_german = [HEADER] + [[german(cell) for cell in row] for row in ROWS]
needs_quotes = lambda cell: f'"{cell}"' if "," in cell else cell
write("excel_english", table([HEADER] + ROWS, end="\r\n"))
write("excel_german", table(all_german, ";", "\r\n"))
write("excel_german_utf8_with_cleared_rows", "\ufeff" + table(all_german, ";", "\r\n") + 3 * (";" * 6 + "\r\n"))
write("excel_german_tabs", table(all_german, "\t", "\r\n"))
write("google_german", table(all_german, end="\r\n", quoted=needs_quotes).removesuffix("\r\n"))

names = {"particle": "Kugel", "liquid": "Flüssigkeit", "film_um": "Film (µm)", "impact_speed_m_s": "v_i, m/s"}
words = {"PTFE": "Teflon", "dry": "trocken", "AK10": "Öl 10"}
write(
    "names_and_words_of_their_own",
    table([[names.get(cell, words.get(cell, german(cell))) for cell in row] for row in [HEADER] + ROWS], ";"),
    "".join(f'columns.{ours} = "{theirs}"\n' for ours, theirs in names.items())
    + 'values.particle = { Teflon = "PTFE" }\nvalues.liquid = { trocken = "dry", "Öl 10" = "AK10" }\n',
)
write("a_constant_column", table([row[1:] for row in [HEADER] + ROWS]), 'constants = { particle = "PTFE" }\n')


def heights(of_film):
    def row_of(run):
        film = float(run["film_um"] or 0) * 1e-6 * of_film
        speed, e = float(run["impact_speed_m_s"]), float(run["restitution"])
        drop, rebound = (1e3 * (v * v / (2 * G) + film) for v in (speed, e * speed))
        return [run["particle"], run["liquid"], run["diameter_mm"], run["film_um"], run["film_ratio"], number(drop)] + [
            number(rebound) if e > 0 else "0"
        ]

    return changed(HEADER[:5] + ["drop_height_mm", "rebound_height_mm"], row_of)


def stokes(run):
    speed = float(run["impact_speed_m_s"])
    scale = DENSITY * float(run["diameter_mm"]) * 1e-3 / (9 * VISCOSITY)
    wet = run["liquid"] != "dry"
    own = [run[name] for name in HEADER[:5]]
    return own + ["" if wet else run["impact_speed_m_s"], number(scale * speed) if wet else "", run["restitution"]]


write("heights_above_the_plate", table(heights(1)))
write("heights_above_the_film", table(heights(0)), 'heights_to = "film"\n')
write("stokes_numbers", table(changed(HEADER[:6] + ["stokes", "restitution"], stokes)))
