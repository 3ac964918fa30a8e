"""Makes the Parquet examples from good/plain/runs.csv. Needs pyarrow (made with 26.0.1): python parquet.py"""

from decimal import Decimal
from pathlib import Path

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

HERE = Path(__file__).parent
NAMES = ["particle", "liquid"]


def read(case):
    names = {name: pa.string() for name in NAMES}
    options = pyarrow.csv.ConvertOptions(column_types=names, strings_can_be_null=True)
    return pyarrow.csv.read_csv(HERE / case / "runs.csv", convert_options=options)


def write(case, table):
    (HERE / case).mkdir(exist_ok=True)
    # plain pages of one block: the smallest file
    pyarrow.parquet.write_table(table, HERE / case / "runs.parquet", compression="zstd", write_statistics=False)


def changed(table, column, values):
    return table.set_column(table.schema.get_field_index(column), column, [values])


def as_text(table):
    for name in table.column_names:
        values = ["NA" if x is None else f" {x}" for x in table[name].to_pylist()]
        array = pa.array(values)
        # names as a factor, as R and pandas write them
        table = changed(table, name, array.dictionary_encode() if name in NAMES else array)
    return table


plain = read("good/plain")
write("good/parquet", plain)
write("errors", read("errors"))
write("good/parquet_of_texts", as_text(plain))
# numbers that mark a run that stuck and a cell that is missing
stuck = pa.array([-1.0 if e == 0 else e for e in plain["restitution"].to_pylist()])
missing = plain["film_ratio"].fill_null(-999.0)
write("good/parquet_with_marks", changed(changed(plain, "restitution", stuck), "film_ratio", missing))
scene = (HERE / "good/plain/scene.toml").read_text()
marks = 'values.restitution = { "-1" = "0" }\nvalues.film_ratio = { "-999" = "NA" }\n'
(HERE / "good/parquet_with_marks/scene.toml").write_text(scene.replace('"runs.csv"\n', '"runs.parquet"\n' + marks))

small = plain.slice(6, 3)
write("bad/parquet_bad_cell", changed(small, "restitution", pa.array([0.58, 1.3, None])))
write("bad/parquet_bad_text", changed(small, "restitution", pa.array(["0.58", "high", "0,7"])))
write("bad/parquet_type", changed(small, "restitution", pa.array([True, True, False])))
write("bad/parquet_decimal", changed(small, "restitution", pa.array([Decimal("0.58")] * 3)))
write("bad/parquet_no_rows", plain.slice(0, 0))
write("bad/parquet_missing_column", small.drop_columns(["impact_speed_m_s"]))
whole = (HERE / "good/parquet/runs.parquet").read_bytes()
(HERE / "bad/parquet_cut_short/runs.parquet").write_bytes(whole[: len(whole) // 2])
