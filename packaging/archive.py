#!/usr/bin/env python3
"""Packs a built program, its manual pages, completions, README and licences into an archive with its checksum.

    python3 packaging/archive.py target/release/wetcor --out target/dist

Writes wetcor-VERSION-MACHINE-SYSTEM.tar.gz (.zip on Windows) and beside it the same name with .sha256, in the form that
`sha256sum -c` reads. The same program gives the same bytes. Runs where the program runs: it prints its own pages.
"""

import argparse
import gzip
import hashlib
import io
import platform
import re
import subprocess
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOCUMENTS = ["README.md", "docs/install.md", "CHANGELOG.md", "CITATION.cff", "LICENSE-APACHE", "LICENSE-MIT"]
# the file in which each shell looks for the completions of `wetcor`, or by custom would
COMPLETIONS = {
    "bash": "wetcor.bash",
    "elvish": "wetcor.elv",
    "fish": "wetcor.fish",
    "powershell": "_wetcor.ps1",
    "zsh": "_wetcor",
}
SYSTEMS = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}
MACHINES = {"AMD64": "x86_64", "ARM64": "arm64", "aarch64": "arm64"}


def printed(program, *arguments):
    return subprocess.run([program, *arguments], check=True, stdout=subprocess.PIPE).stdout


def contents(program):
    """What lies in the archive: each file's name, its bytes, and whether it is run."""
    yield program.name, program.read_bytes(), True
    for name in DOCUMENTS:
        yield name, (ROOT / name).read_bytes(), False
    page = printed(program, "man")
    yield "man/man1/wetcor.1", page, False
    commands = re.findall(r"^wetcor\\-([a-z]+)\(1\)$", page.decode("ascii"), re.MULTILINE)
    for command in commands:
        yield f"man/man1/wetcor-{command}.1", printed(program, "man", command), False
    for shell, name in COMPLETIONS.items():
        yield f"completions/{name}", printed(program, "completions", shell), False


def tar_gz(folder, files):
    packed = io.BytesIO()
    # no times and no names of users: the bytes follow from the contents alone
    with gzip.GzipFile(filename="", fileobj=packed, mode="wb", mtime=0) as zipped:
        with tarfile.open(fileobj=zipped, mode="w", format=tarfile.USTAR_FORMAT) as archive:
            for name, data, is_run in files:
                entry = tarfile.TarInfo(f"{folder}/{name}")
                entry.size = len(data)
                entry.mode = 0o755 if is_run else 0o644
                archive.addfile(entry, io.BytesIO(data))
    return packed.getvalue()


def zip_(folder, files):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data, _ in files:
            archive.writestr(zipfile.ZipInfo(f"{folder}/{name}"), data, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program", type=Path, help="the built program")
    options.add_argument("--out", type=Path, required=True, help="folder to write into")
    options = options.parse_args()
    program = options.program.resolve()

    version = printed(program, "--version").decode("ascii").split()[1]
    machine = platform.machine()
    system = SYSTEMS[platform.system()]
    folder = f"wetcor-{version}-{MACHINES.get(machine, machine)}-{system}"
    ending, pack = (".zip", zip_) if system == "windows" else (".tar.gz", tar_gz)
    packed = pack(folder, list(contents(program)))

    options.out.mkdir(parents=True, exist_ok=True)
    archive = options.out / f"{folder}{ending}"
    archive.write_bytes(packed)
    # as bytes: Windows would end the line in a way that `sha256sum -c` takes for a part of the name
    line = f"{hashlib.sha256(packed).hexdigest()}  {archive.name}\n"
    (options.out / f"{archive.name}.sha256").write_bytes(line.encode("ascii"))
    print(archive)


if __name__ == "__main__":
    main()
