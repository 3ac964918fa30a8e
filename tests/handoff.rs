//! Holds `wetcor handoff` to the predictions of the same fit; `transcripts` hold its refusals.

use crate::common::{ask, fitted_example as example};
use crate::laws::rows;

const WET: &str = "--particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286";
const DRY: &str = "--particle PTFE --liquid dry --diameter-mm 4.762";

/// The numbers of a column of a table, whose comments are left out.
fn column(table: &str, name: &str) -> Vec<f64> {
    let lines: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).collect();
    let rows = rows(&lines.join("\n")).into_iter();
    rows.map(|row| row[name].parse().expect("a number")).collect()
}

#[test]
fn the_table_is_what_is_predicted() {
    for pair in [WET, DRY] {
        let (status, table, err) = ask("handoff", example(), &format!("{pair} --speed-m-s 1.2 --to table"));
        assert_eq!((status, err.as_str()), (Some(0), ""));
        let [v, e, low, beyond] = ["v_m_s", "e_q50", "e_q05", "extrapolated"].map(|name| column(&table, name));
        let are_both = [0.0, 1.0].iter().all(|mark| beyond.contains(mark));
        assert!(v.len() > 20 && are_both, "{table}");
        for place in (0..v.len()).step_by(5) {
            let speed = v[place];
            let (_, predicted, _) = ask("predict", example(), &format!("{pair} --speed-m-s {speed}:{speed}:1"));
            // the table has five digits
            for (name, told) in [("restitution", e[place]), ("restitution_q05", low[place])] {
                assert!((column(&predicted, name)[0] - told).abs() < 1e-5, "{speed} {predicted}");
            }
            let marked = predicted.contains(",true");
            assert_eq!(marked, beyond[place] == 1.0, "{speed}");
        }
    }
}
