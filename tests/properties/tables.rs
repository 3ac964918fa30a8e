//! Holds that a table reads to the same runs however it is written, and that a bad cell is named.

use proptest::prelude::*;
use proptest::sample::{select, Index};
use wetcor::runs::Table;
use wetcor::units::{Dimension, Unit};

use super::{assert_every_row_counted, assert_told, hold, same, Folder};

/// One run in the units of its columns' usual names.
#[derive(Debug, Clone, Copy)]
struct Run {
    particle: &'static str,
    /// liquid, film in µm, and nominal film ratio
    wet: Option<(&'static str, f64, f64)>,
    diameter: f64,
    speed: f64,
    restitution: f64,
}

prop_compose! {
    fn any_run()(
        particle in select(vec!["PTFE", "PE.2"]),
        wet in prop::option::weighted(0.7, (select(vec!["AK10", "M-50"]), select(vec![0.03f64, 0.06, 0.12, 0.6]))),
        diameter in select(vec![3.175f64, 4.762, 8.0]),
        speed in 0.01f64..5.0,
        restitution in prop_oneof![1 => Just(0.0f64), 4 => 0.001f64..1.1],
    ) -> Run {
        let rounded = |x: f64| (x * 1e4).round() / 1e4;
        Run {
            particle,
            wet: wet.map(|(liquid, ratio): (_, f64)| (liquid, (1e3 * ratio * diameter).round(), ratio)),
            diameter,
            speed: rounded(speed),
            restitution: rounded(restitution),
        }
    }
}

const TWO_OF_EACH: &str =
    "[data]\nruns = \"runs.csv\"\nmin_film_um = 200\nmax_film_ratio = 0.1\nmin_impact_speed_m_s = 0.05\n\
    max_impact_speed_m_s = 4\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n[particles.\"PE.2\"]\n\
    density_kg_m3 = 950\nroughness_um = 7\n[liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n\
    [liquids.M-50]\ndensity_kg_m3 = 965\nviscosity_mPa_s = 50\n";

/// How a table is written down.
#[derive(Debug, Clone)]
struct Dress {
    end: &'static str,
    mark: &'static str,
    missing: &'static str,
    dry: &'static str,
    /// units of diameter, film and speed
    units: [Unit; 3],
    nominal: bool,
    /// columns, one of them unknown, in any order
    order: Vec<usize>,
    /// what to do to each cell in turn: nothing, quotes, blanks
    cells: Vec<u8>,
    blank_lines: Vec<Index>,
}

fn unit(dimension: Dimension) -> impl Strategy<Value = Unit> {
    select(dimension.units().to_vec())
}

prop_compose! {
    fn dress()(
        end in select(vec!["\n", "\r\n", "\r"]),
        mark in select(vec!["", "\u{feff}"]),
        missing in select(vec!["", "NA"]),
        dry in select(vec!["", "dry", "NA"]),
        units in [unit(Dimension::Length), unit(Dimension::Thickness), unit(Dimension::Speed)],
        nominal in any::<bool>(),
        order in Just((0..8).collect::<Vec<usize>>()).prop_shuffle(),
        cells in prop_oneof![Just(vec![0]), prop::collection::vec(0u8..4, 1..20)],
        blank_lines in prop::collection::vec(any::<Index>(), 0..3),
    ) -> Dress {
        Dress { end, mark, missing, dry, units, nominal, order, cells, blank_lines }
    }
}

impl Dress {
    /// The usual one.
    fn plain(nominal: bool) -> Dress {
        let units = [Dimension::Length, Dimension::Thickness, Dimension::Speed].map(|dimension| dimension.units()[0]);
        Dress {
            end: "\n",
            mark: "",
            missing: "",
            dry: "dry",
            units,
            nominal,
            order: (0..8).collect(),
            cells: vec![0],
            blank_lines: vec![],
        }
    }

    fn header(&self) -> [String; 8] {
        let [diameter, film, speed] = self.units.map(|unit| unit.suffix);
        [
            "particle".to_owned(),
            "liquid".to_owned(),
            format!("diameter{diameter}"),
            format!("film{film}"),
            if self.nominal { "film_ratio" } else { "thought_of_later" }.to_owned(),
            format!("impact_speed{speed}"),
            "restitution".to_owned(),
            "operator's remark".to_owned(),
        ]
    }

    fn cells(&self, run: &Run) -> [String; 8] {
        let usual = Dress::plain(true).units;
        let number = |which: usize, x: f64| format!("{}", self.units[which].from_si(usual[which].to_si(x)));
        let missing = || self.missing.to_owned();
        [
            run.particle.to_owned(),
            run.wet.map_or(self.dry, |(liquid, ..)| liquid).to_owned(),
            number(0, run.diameter),
            match run.wet {
                Some((_, film, _)) => number(1, film),
                // an empty liquid may be one that is written once a block
                None if self.dry != "dry" => "0".to_owned(),
                None => missing(),
            },
            run.wet.map_or_else(missing, |(_, _, ratio)| ratio.to_string()),
            number(2, run.speed),
            run.restitution.to_string(),
            "ok".to_owned(),
        ]
    }

    /// A table of rows, and the line of each, from 1; the header is the first of both.
    fn table(&self, rows: &[[String; 8]]) -> (String, Vec<usize>) {
        let mut text = self.mark.to_owned();
        let (mut line, mut lines) = (1, vec![]);
        let mut dresses = self.cells.iter().cycle();
        for (index, row) in rows.iter().enumerate() {
            for _ in self.blank_lines.iter().filter(|at| at.index(rows.len()) == index) {
                text.push_str(self.end);
                line += 1;
            }
            let cells: Vec<String> = self
                .order
                .iter()
                .map(|column| match (dresses.next(), &row[*column]) {
                    (Some(1), cell) => format!("\"{cell}\""),
                    (Some(2), cell) => format!(" {cell}\t "),
                    (Some(3), cell) => format!("\u{a0}{cell} "),
                    (_, cell) => cell.clone(),
                })
                .collect();
            text.push_str(&cells.join(","));
            text.push_str(self.end);
            lines.push(line);
            line += 1;
        }
        (text, lines)
    }

    fn rows(&self, runs: &[Run]) -> Vec<[String; 8]> {
        std::iter::once(self.header())
            .chain(runs.iter().map(|run| self.cells(run)))
            .collect()
    }
}

/// Where two tables differ by more than roundings.
fn assert_same(a: &Table, b: &Table) {
    assert_eq!((a.rows, &a.screened), (b.rows, &b.screened));
    let (x, y) = (&a.runs, &b.runs);
    for (x, y) in [
        (&x.diameter, &y.diameter),
        (&x.film, &y.film),
        (&x.impact_speed, &y.impact_speed),
        (&x.restitution, &y.restitution),
    ] {
        let is_same = x.len() == y.len() && x.iter().zip(y).all(|(x, y)| same(*x, *y));
        assert!(is_same, "{x:?}\n{y:?}");
    }
    let groups = |table: &Table| {
        let (series, dry) = (table.runs.series.iter(), table.runs.dry.iter());
        let series = series.map(|s| (s.particle, s.liquid, s.runs(), s.stuck.clone()));
        let dry = dry.map(|g| (g.particle, g.rebounds.clone(), g.stuck.clone()));
        let films = table.runs.film_groups.iter().map(|g| (g.particle, g.series.clone()));
        (
            series.collect::<Vec<_>>(),
            dry.collect::<Vec<_>>(),
            films.collect::<Vec<_>>(),
        )
    };
    assert_eq!(groups(a), groups(b));
}

#[test]
fn a_table_reads_to_the_same_runs_in_any_dress() {
    let folder = Folder::new();
    let scene = folder.scene(TWO_OF_EACH).expect("a good scene");
    let name = "a_table_reads_to_the_same_runs_in_any_dress";
    let inputs = (prop::collection::vec(any_run(), 1..30), dress());
    hold(name, 1500, inputs, |(rows, dress)| {
        let plain = Dress::plain(dress.nominal);
        let read = |dress: &Dress| {
            let text = dress.table(&dress.rows(&rows)).0;
            folder
                .runs(&scene, &text)
                .unwrap_or_else(|error| panic!("{error}\n{text}"))
        };
        let (plain, dressed) = (read(&plain), read(&dress));
        assert_same(&dressed, &plain);
        assert_every_row_counted(&dressed);
        // none is lost and none invented: the runs within the screens, counted by other means
        let kept = |run: &&Run| {
            let film = run
                .wet
                .is_none_or(|(_, film, _)| film >= 200.0 && film / run.diameter <= 100.0);
            (0.05..=4.0).contains(&run.speed) && film
        };
        let mut expected: Vec<u64> = rows.iter().filter(kept).map(|run| run.restitution.to_bits()).collect();
        let mut found: Vec<u64> = dressed.runs.restitution.iter().map(|e| e.to_bits()).collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected);
    });
}

#[test]
fn a_bad_cell_is_named_by_line_column_and_value() {
    let folder = Folder::new();
    let scene = folder.scene(TWO_OF_EACH).expect("a good scene");
    let name = "a_bad_cell_is_named_by_line_column_and_value";
    // by the column: a name that is none, numbers that cannot be
    let numbers = "x nan -1 inf 1e308 0x10 1e999 4.0.0 ٤";
    let bad = [
        (0, "PTFA ptfe"),
        (1, "AK11"),
        (2, numbers),
        (5, numbers),
        (6, "1.2 -0.1 NaN e"),
    ];
    let bad = bad.map(|(column, cells)| cells.split(' ').map(move |cell| (column, cell)));
    let bad: Vec<(usize, &str)> = bad.into_iter().flatten().collect();
    let runs = prop::collection::vec(any_run(), 1..30);
    let inputs = (runs, dress(), any::<Index>(), select(bad));
    hold(name, 1500, inputs, |(runs, dress, which, (column, cell))| {
        let mut rows = dress.rows(&runs);
        let row = 1 + which.index(runs.len());
        // a dry run with a liquid lacks a film as well
        if column == 1 && runs[row - 1].wet.is_none() {
            return;
        }
        rows[row][column] = cell.to_owned();
        let (text, lines) = dress.table(&rows);
        let error = folder.runs(&scene, &text).expect_err("a bad cell");
        let told = assert_told(&error, "runs.csv");
        let expected = format!(
            "line {}, column {}: found `{cell}`, expected ",
            lines[row], rows[0][column]
        );
        assert!(told.contains(&expected), "{expected}\n{told}\n{text}");
        assert!(told.contains(": 1 problem;"), "{told}");
    });
}
