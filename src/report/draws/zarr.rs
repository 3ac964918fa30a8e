//! Lays groups of arrays out as a Zarr store (format 3) that xarray and ArviZ open as they are.
//!
//! A folder each for the store, its groups and their arrays, with a `zarr.json`; an array's values are one raw
//! little-endian chunk beside it (or several, see [`Values::Apart`]), so that nothing need be compressed to be written or
//! understood to be read. The store's own `zarr.json` repeats all the others (consolidated metadata), so that a reader
//! opens one file instead of all. Text is UTF-32 of the longest entry's length: of the string types of zarr-python 3, one that
//! xarray writes and reads itself.
//! Source: the Zarr 3 core specification, <https://zarr-specs.readthedocs.io/en/latest/v3/core/index.html>.

use serde_json::{json, Map, Value};

use crate::error::Error;
use crate::report::folder::File;
use crate::report::json;

/// Values of an array, the last dimension running fastest.
#[derive(Debug, Clone, PartialEq)]
pub enum Values<'a> {
    /// numbers; one that is not finite is kept as it is
    F64(&'a [f64]),
    /// the same as they lie in the file, little end first
    F64Bytes(Vec<u8>),
    /// numbers too many to be held: the caller writes a chunk for each index of the first dimension and each [`PART`] of the
    /// second to [`chunk_path`], as raw f32, little end first; the last one is filled up
    Apart,
    /// counts
    I64(&'a [i64]),
    /// flags
    Bool(&'a [bool]),
    /// names, as of a coordinate; trailing NUL characters are lost
    Text(&'a [String]),
}

/// File that describes the store, a group or an array.
const NODE: &str = "zarr.json";

/// Length along the second dimension of a chunk that the caller writes: a few megabytes where runs are thousands.
pub const PART: usize = 256;

/// An array of a group. One that bears the name of its only dimension is that dimension's coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Array<'a> {
    /// name inside the group: letters and digits of ASCII and `_`, as it is a folder's, too
    pub name: &'a str,
    /// names of the dimensions
    pub dimensions: &'a [&'a str],
    /// length along each dimension
    pub shape: &'a [usize],
    /// as many values as the shape asks for
    pub values: Values<'a>,
}

/// A group of arrays: for ArviZ posterior, sample_stats, log_likelihood and so on.
#[derive(Debug, Clone, PartialEq)]
pub struct Group<'a> {
    /// name, of the same letters
    pub name: &'a str,
    /// what is said of the group
    pub attributes: Map<String, Value>,
    /// coordinates and variables, in any order; those that share a dimension agree on its length
    pub arrays: Vec<Array<'a>>,
}

/// Every file of a store at `root` (a path inside the report's folder): the same bytes for the same groups.
///
/// Fails where a name could lead to another place, and where an array has fewer or more values than its shape asks for, or
/// another length of a dimension than its group.
pub fn store(root: &str, attributes: Map<String, Value>, groups: Vec<Group>) -> Result<Vec<File>, Error> {
    let mut files = vec![];
    let mut all = Map::new();
    for group in groups {
        agree(&group)?;
        let node = group_node(group.attributes);
        files.push(node_file(&format!("{root}/{}", group.name), &node)?);
        all.insert(group.name.to_owned(), node);
        for array in group.arrays {
            let path = format!("{}/{}", group.name, array.name);
            let node = array_node(&array);
            files.push(node_file(&format!("{root}/{path}"), &node)?);
            let bytes = chunk(array.values);
            if !bytes.is_empty() {
                files.push((
                    chunk_path(root, group.name, array.name, &vec![0; array.shape.len()]),
                    bytes,
                ));
            }
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

fn agree(group: &Group) -> Result<(), Error> {
    let mut lengths: Vec<(&str, usize)> = vec![];
    let fail = |array: &str, reason: String| {
        Err(Error::Internal {
            doing: "write draws.zarr",
            reason: format!("{}/{array}: {reason}", group.name),
        })
    };
    let plain = |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    for array in &group.arrays {
        let fail = |reason: String| fail(array.name, reason);
        if !(plain(group.name) && plain(array.name)) {
            return fail("is no name of letters, digits and `_`".to_owned());
        }
        let count: usize = array.shape.iter().product();
        if array.dimensions.len() != array.shape.len() {
            return fail(format!("{:?} has not the lengths {:?}", array.dimensions, array.shape));
        }
        if let Some(values) = array.values.len().filter(|values| *values != count) {
            return fail(format!("{values} values for {:?}", array.shape));
        }
        for (&dimension, &length) in array.dimensions.iter().zip(array.shape) {
            match lengths.iter().find(|(name, _)| *name == dimension) {
                Some((_, other)) if *other != length => return fail(format!("{dimension} is {length} and {other}")),
                Some(_) => {}
                None => lengths.push((dimension, length)),
            }
        }
    }
    Ok(())
}

impl Values<'_> {
    /// As many as are here.
    fn len(&self) -> Option<usize> {
        match self {
            Values::F64(values) => Some(values.len()),
            Values::F64Bytes(bytes) => Some(bytes.len() / size_of::<f64>()),
            Values::Apart => None,
            Values::I64(values) => Some(values.len()),
            Values::Bool(values) => Some(values.len()),
            Values::Text(values) => Some(values.len()),
        }
    }
}

fn node_file(folder: &str, node: &Value) -> Result<File, Error> {
    Ok((format!("{folder}/{NODE}"), json::text(node)?.into_bytes()))
}

fn group_node(attributes: Map<String, Value>) -> Value {
    json!({"zarr_format": 3, "node_type": "group", "attributes": attributes})
}

fn array_node(array: &Array) -> Value {
    let little = json!({"name": "bytes", "configuration": {"endian": "little"}});
    let (data_type, fill, codec) = match &array.values {
        Values::F64(_) | Values::F64Bytes(_) => (json!("float64"), json!("NaN"), little),
        Values::Apart => (json!("float32"), json!("NaN"), little),
        Values::I64(_) => (json!("int64"), json!(0), little),
        // single bytes have no order
        Values::Bool(_) => (json!("bool"), json!(false), json!({"name": "bytes"})),
        Values::Text(values) => {
            let length = 4 * longest(values);
            let text = json!({"name": "fixed_length_utf32", "configuration": {"length_bytes": length}});
            (text, json!(""), little)
        }
    };
    // a chunk has a length of at least one, even where the array has none
    let mut chunk: Vec<usize> = array.shape.iter().map(|&length| length.max(1)).collect();
    if matches!(array.values, Values::Apart) {
        for (length, most) in chunk.iter_mut().zip([1, PART]) {
            *length = most.min(*length);
        }
    }
    json!({
        "zarr_format": 3,
        "node_type": "array",
        "shape": array.shape,
        "data_type": data_type,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": fill,
        "codecs": [codec],
        "attributes": {},
        "dimension_names": array.dimensions,
    })
}

/// Characters of the longest text, at least one.
fn longest(texts: &[String]) -> usize {
    texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1)
}

fn chunk(values: Values) -> Vec<u8> {
    match values {
        Values::F64(values) => little(values.iter().map(|x| x.to_le_bytes())),
        Values::F64Bytes(bytes) => bytes,
        // the caller's to write
        Values::Apart => vec![],
        Values::I64(values) => little(values.iter().map(|x| x.to_le_bytes())),
        Values::Bool(values) => values.iter().map(|&x| u8::from(x)).collect(),
        Values::Text(texts) => {
            let length = longest(texts);
            let padded = |text: &String| {
                let mut letters: Vec<u32> = text.chars().map(u32::from).collect();
                letters.resize(length, 0);
                letters
            };
            let letters: Vec<u32> = texts.iter().flat_map(padded).collect();
            little(letters.iter().map(|x| x.to_le_bytes()))
        }
    }
}

/// Bytes one value after another.
fn little<const N: usize>(values: impl ExactSizeIterator<Item = [u8; N]>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(N * values.len());
    values.for_each(|value| bytes.extend_from_slice(&value));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file<'a>(files: &'a [File], path: &str) -> &'a [u8] {
        let found = files.iter().find(|(name, _)| name == path);
        &found.unwrap_or_else(|| panic!("no {path}")).1
    }

    fn node(files: &[File], path: &str) -> Value {
        serde_json::from_slice(file(files, path)).expect("JSON")
    }

    #[test]
    fn values_are_where_the_format_has_them() {
        let names = ["PE".to_owned(), "µPTFE".to_owned()];
        let group = Group {
            name: "posterior",
            attributes: Map::new(),
            arrays: vec![
                Array {
                    name: "dry_k",
                    dimensions: &["chain", "draw", "particle"],
                    shape: &[1, 2, 2],
                    values: Values::F64(&[0.1, f64::NAN, -0.0, 1e300]),
                },
                Array {
                    name: "many",
                    dimensions: &["chain", "draw"],
                    shape: &[1, 2],
                    values: Values::Apart,
                },
                Array {
                    name: "particle",
                    dimensions: &["particle"],
                    shape: &[2],
                    values: Values::Text(&names),
                },
                Array {
                    name: "n_steps",
                    dimensions: &["draw"],
                    shape: &[2],
                    values: Values::I64(&[7, -1]),
                },
                Array {
                    name: "diverging",
                    dimensions: &["draw"],
                    shape: &[2],
                    values: Values::Bool(&[true, false]),
                },
            ],
        };
        let root = Map::from_iter([("model".to_owned(), json!("stepwise/2"))]);
        let files = store("draws.zarr", root.clone(), vec![group.clone()]).expect("a store");
        assert_eq!(
            store("draws.zarr", root, vec![group]).expect("a store"),
            files,
            "the same bytes again"
        );

        let chunk = file(&files, "draws.zarr/posterior/dry_k/c.0.0.0");
        let numbers: Vec<u64> = chunk
            .chunks_exact(8)
            .map(|bytes| u64::from_le_bytes(bytes.try_into().expect("eight bytes")))
            .collect();
        assert_eq!(numbers, [0.1, f64::NAN, -0.0, 1e300].map(f64::to_bits));
        assert_eq!(file(&files, "draws.zarr/posterior/n_steps/c.0")[8..], [255; 8]);
        assert_eq!(file(&files, "draws.zarr/posterior/diverging/c.0"), [1, 0]);
        let text = file(&files, "draws.zarr/posterior/particle/c.0");
        let letters: Vec<char> = text
            .chunks_exact(4)
            .filter_map(|bytes| char::from_u32(u32::from_le_bytes(bytes.try_into().expect("four bytes"))))
            .collect();
        assert_eq!(letters, ['P', 'E', '\0', '\0', '\0', 'µ', 'P', 'T', 'F', 'E']);

        let array = node(&files, "draws.zarr/posterior/dry_k/zarr.json");
        assert_eq!(array["shape"], json!([1, 2, 2]));
        assert_eq!(array["dimension_names"], json!(["chain", "draw", "particle"]));
        let many = node(&files, "draws.zarr/posterior/many/zarr.json");
        assert_eq!(many["data_type"], "float32");
        assert_eq!(many["chunk_grid"]["configuration"]["chunk_shape"], json!([1, 2]));
        let apart = chunk_path("draws.zarr", "posterior", "many", &[0, 0]);
        assert_eq!(apart, "draws.zarr/posterior/many/c.0.0");
        assert!(files.iter().all(|(path, _)| *path != apart), "the caller's to write");
        let all = node(&files, "draws.zarr/zarr.json");
        assert_eq!(all["attributes"]["model"], "stepwise/2");
        let consolidated = &all["consolidated_metadata"]["metadata"];
        assert_eq!(consolidated["posterior/dry_k"], array);
        assert_eq!(
            consolidated["posterior"],
            node(&files, "draws.zarr/posterior/zarr.json")
        );
        assert_eq!(consolidated.as_object().map(Map::len), Some(6));
    }

    #[test]
    fn an_array_without_values_has_no_chunk_and_one_that_disagrees_no_store() {
        let with = |arrays| Group {
            name: "g",
            attributes: Map::new(),
            arrays,
        };
        let of_length = |name, length, values| Array {
            name,
            dimensions: &["x"],
            shape: length,
            values: Values::F64(values),
        };
        let empty = store("s", Map::new(), vec![with(vec![of_length("a", &[0], &[])])]).expect("a store");
        let paths: Vec<&str> = empty.iter().map(|(path, _)| path.as_str()).collect();
        assert_eq!(paths, ["s/g/zarr.json", "s/g/a/zarr.json", "s/zarr.json"]);
        for name in ["", ".", "..", "a/b", "a\\b", "a\0", "ä"] {
            assert!(
                store("s", Map::new(), vec![with(vec![of_length(name, &[1], &[1.0])])]).is_err(),
                "{name:?}"
            );
        }
        let short = with(vec![of_length("a", &[2], &[1.0])]);
        assert!(store("s", Map::new(), vec![short]).is_err());
        let apart = with(vec![of_length("a", &[2], &[1.0; 2]), of_length("b", &[3], &[1.0; 3])]);
        assert!(store("s", Map::new(), vec![apart]).is_err());
    }
}
