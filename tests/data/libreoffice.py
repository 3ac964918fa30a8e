"""Makes LibreOffice write good/workbook/runs.xlsx as a German CSV and as a workbook of its own: python libreoffice.py

Needs soffice (made with LibreOffice 7.4.7.2 of Debian 12, package libreoffice-calc). The numbers after the name of the filter
are its documented tokens: separator (comma), quote, UTF-8, first line, no cell formats, language, texts unquoted, cells as
shown. The locale of the system is that of the profile.
"""

import subprocess
import tempfile
from pathlib import Path

GOOD = Path(__file__).parent / "good"
GERMAN = """<?xml version="1.0" encoding="UTF-8"?>
<oor:items xmlns:oor="http://openoffice.org/2001/registry">
<item oor:path="/org.openoffice.Setup/L10N">
<prop oor:name="ooSetupSystemLocale" oor:op="fuse"><value>de-DE</value></prop>
</item>
</oor:items>
"""


def convert(case, to, runs):
    folder = GOOD / case
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as profile:
        user = Path(profile) / "user"
        user.mkdir()
        (user / "registrymodifications.xcu").write_text(GERMAN)
        office = ["soffice", f"-env:UserInstallation={Path(profile).as_uri()}", "--headless"]
        source = GOOD / "workbook" / "runs.xlsx"
        subprocess.run([*office, "--convert-to", to, "--outdir", folder, source], check=True)
    scene = (GOOD / "plain" / "scene.toml").read_text()
    (folder / "scene.toml").write_text(scene.replace('"runs.csv"', f'"{runs}"'))


convert("libreoffice_german", "csv:Text - txt - csv (StarCalc):44,34,76,1,,1031,false,true", "runs.csv")
convert("libreoffice_workbook", "xlsx:Calc MS Excel 2007 XML", "runs.xlsx")
