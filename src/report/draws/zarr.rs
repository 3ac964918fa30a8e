//! Lays groups of arrays out as a Zarr store (format 3) that xarray and ArviZ open as they are.
//!
//! A folder each for the store, its groups and their arrays, with a `zarr.json`; an array's values are one raw
//! little-endian chunk beside it (or several, see [`PART`]), so that nothing need be compressed to be written or
//! understood to be read. The store's own `zarr.json` repeats all the others (consolidated metadata), so that a reader
//! opens one file instead of all. Text is UTF-32 of the longest entry's length: of the string types of zarr-python 3, one that
//! xarray writes and reads itself.
//! Source: the Zarr 3 core specification, <https://zarr-specs.readthedocs.io/en/latest/v3/core/index.html>.

use serde_json::{json, Map, Value};

use super::arrays::{ArrayGroup, DrawArray};
use crate::error::Error;
use crate::report::folder::File;
use crate::report::json;

/// File that describes the store, a group or an array.
const NODE: &str = "zarr.json";

/// Length along the second dimension of a chunk that the caller writes: a few megabytes where runs are thousands.
///
/// Of an array whose values are not held the caller writes a chunk for each index of the first dimension and each part of
/// the second to [`chunk_path`], as raw f32, little end first; the last one is filled up.
pub const PART: usize = 256;

/// Every file of a store at `root` (a path inside the report's folder): the same bytes for the same groups.
///
/// Names of groups and arrays are letters and digits of ASCII and `_`, as they are folders', too.
pub fn store(root: &str, attributes: Map<String, Value>, groups: Vec<ArrayGroup>) -> Result<Vec<File>, Error> {
    let mut files = vec![];
    let mut all = Map::new();
    for group in groups {
        let node = group_node(Map::new());
        files.push(node_file(&format!("{root}/{}", group.name), &node)?);
        all.insert(group.name.to_owned(), node);
        for array in group.arrays {
            let path = format!("{}/{}", group.name, array.name);
            let node = array_node(&array);
            files.push(node_file(&format!("{root}/{path}"), &node)?);
            let chunk = chunk_path(root, group.name, &array.name, &vec![0; array.dimensions.len()]);
            let bytes = array.values.bytes.filter(|bytes| !bytes.is_empty());
            files.extend(bytes.map(|bytes| (chunk, bytes)));
            all.insert(path, node);
        }
    }
    let mut node = group_node(attributes);
    node["consolidated_metadata"] = json!({"kind": "inline", "must_understand": false, "metadata": all});
    files.push(node_file(root, &node)?);
    Ok(files)
}

/// Where the chunk at this place of the grid lies, for a store at `root`.
pub fn chunk_path(root: &str, group: &str, array: &str, place: &[usize]) -> String {
    let place: Vec<String> = place.iter().map(|index| format!(".{index}")).collect();
    format!("{root}/{group}/{array}/c{}", place.concat())
}

/// Whether a file of a store may have this name: it describes a group or an array, or is a chunk of one.
pub fn is_file_name(name: &str) -> bool {
    let is_place = |place: &str| !place.is_empty() && place.bytes().all(|byte| byte.is_ascii_digit());
    match name.split_once('.') {
        Some(("c", place)) => place.split('.').all(is_place),
        _ => name == NODE || name == "c",
    }
}

fn node_file(folder: &str, node: &Value) -> Result<File, Error> {
    Ok((format!("{folder}/{NODE}"), json::text(node)?.into_bytes()))
}

fn group_node(attributes: Map<String, Value>) -> Value {
    json!({"zarr_format": 3, "node_type": "group", "attributes": attributes})
}

fn array_node(array: &DrawArray) -> Value {
    let values = &array.values;
    let (names, shape): (Vec<&str>, Vec<usize>) = array.dimensions.iter().copied().unzip();
    // single bytes have no order
    let codec = match values.data_type == "bool" {
        true => json!({"name": "bytes"}),
        false => json!({"name": "bytes", "configuration": {"endian": "little"}}),
    };
    // a chunk has a length of at least one, even where the array has none
    let mut chunk: Vec<usize> = shape.iter().map(|&length| length.max(1)).collect();
    if values.bytes.is_none() {
        for (length, most) in chunk.iter_mut().zip([1, PART]) {
            *length = most.min(*length);
        }
    }
    json!({
        "zarr_format": 3,
        "node_type": "array",
        "shape": shape,
        "data_type": values.data_type,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": values.fill,
        "codecs": [codec],
        "attributes": {},
        "dimension_names": names,
    })
}

#[cfg(test)]
mod tests {
    use super::super::arrays::ArrayValues;
    use super::*;

    fn file<'a>(files: &'a [File], path: &str) -> &'a [u8] {
        let found = files.iter().find(|(name, _)| name == path);
        &found.unwrap_or_else(|| panic!("no {path}")).1
    }

    /// The true reader is ArviZ, which CI has open the draws of the example.
    #[test]
    fn values_are_where_the_format_has_them() {
        let names = ["PE".to_owned(), "µPTFE".to_owned()];
        let reals = [0.1, f64::NAN, -0.0, 1e300];
        let [chain, draw, particle] = [("chain", 1), ("draw", 2), ("particle", 2)];
        let mut group = ArrayGroup::new("posterior");
        group.add("dry_k", &[chain, draw, particle], ArrayValues::reals(reals));
        group.add("many", &[chain, draw], ArrayValues::streamed());
        group.add("particle", &[particle], ArrayValues::texts(&names));
        group.add("n_steps", &[draw], ArrayValues::counts([7, -1]));
        group.add("diverging", &[draw], ArrayValues::flags([true, false]));
        let files = store("draws.zarr", Map::new(), vec![group]).expect("a store");

        let bits = reals.map(|real| real.to_bits().to_le_bytes()).concat();
        assert_eq!(file(&files, "draws.zarr/posterior/dry_k/c.0.0.0"), bits);
        assert_eq!(file(&files, "draws.zarr/posterior/n_steps/c.0")[8..], [255; 8]);
        assert_eq!(file(&files, "draws.zarr/posterior/diverging/c.0"), [1, 0]);
        let letters = "PE\0\0\0µPTFE".chars();
        let letters: Vec<u8> = letters.flat_map(|letter| u32::from(letter).to_le_bytes()).collect();
        assert_eq!(file(&files, "draws.zarr/posterior/particle/c.0"), letters);

        let many = file(&files, "draws.zarr/posterior/many/zarr.json");
        let many: Value = serde_json::from_slice(many).expect("JSON");
        assert_eq!(many["data_type"], "float32");
        assert_eq!(many["chunk_grid"]["configuration"]["chunk_shape"], json!([1, 2]));
        let apart = chunk_path("draws.zarr", "posterior", "many", &[0, 0]);
        assert_eq!(apart, "draws.zarr/posterior/many/c.0.0");
        assert!(files.iter().all(|(path, _)| *path != apart), "the caller's to write");
    }

    #[test]
    fn an_array_without_values_has_no_chunk() {
        let mut group = ArrayGroup::new("g");
        group.add("a", &[("x", 0)], ArrayValues::reals([]));
        let empty = store("s", Map::new(), vec![group]).expect("a store");
        let paths: Vec<&str> = empty.iter().map(|(path, _)| path.as_str()).collect();
        assert_eq!(paths, ["s/g/zarr.json", "s/g/a/zarr.json", "s/zarr.json"]);
    }
}
