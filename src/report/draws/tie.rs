//! Ties draws to the findings they were made with: the store names both by their hashes.
//!
//! A table that R reads has no room for such a word, so the store beside it vouches for the table, too.

use serde::Deserialize;
use serde_json::Value;

use crate::seed::sha256;

/// Where the table of draws lies in a report's folder.
pub const TABLE: &str = "draws/draws.csv";
/// Where the store lies in a report's folder.
pub const STORE: &str = "draws/draws.zarr";

/// Hashes of what belongs together, among the attributes of the store.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Tie {
    /// SHA-256 of `findings.json`
    pub findings_sha256: String,
    /// SHA-256 of `draws.csv`
    pub draws_csv_sha256: String,
}

impl Tie {
    /// Ties the bytes of both files.
    pub fn of(findings: &[u8], table: &[u8]) -> Tie {
        Tie {
            findings_sha256: sha256(findings),
            draws_csv_sha256: sha256(table),
        }
    }

    /// The hashes under their names.
    pub fn attributes(self) -> [(String, Value); 2] {
        [
            ("findings_sha256".to_owned(), Value::String(self.findings_sha256)),
            ("draws_csv_sha256".to_owned(), Value::String(self.draws_csv_sha256)),
        ]
    }

    /// What the `zarr.json` of a store says.
    ///
    /// Fails where it says nothing of it: it is none of ours, or of an earlier version.
    pub fn of_store(root: &[u8]) -> Result<Tie, serde_json::Error> {
        #[derive(Deserialize)]
        struct Root {
            attributes: Tie,
        }
        serde_json::from_slice::<Root>(root).map(|root| root.attributes)
    }
}
