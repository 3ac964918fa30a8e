//! Tests a law against its own runs: misfit between speeds against scatter within them, or against one more power.

use super::nested::{nested, FTest, Spread};

/// Speeds within this share of the slowest of them are repeats of one: the dry law moves by less than 0.001 over it.
const SAME_SPEED: f64 = 0.02;

/// Thirds of the runs, by speed, that have a parameter each.
const PARTS: usize = 3;

/// A run beside the law fitted to its group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawRow {
    /// which group: each has its own parameter
    pub group: usize,
    /// impact speed, m/s
    pub speed: f64,
    /// measured minus law
    pub residual: f64,
    /// slope of the law in its parameter
    pub slope: f64,
    /// the next power of the speed that the law does not have
    pub next_power: f64,
    /// 1/variance, up to a factor that all share; 0 for a run left out
    pub weight: f64,
}

/// What a law is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Alternative {
    /// a mean of its own at every speed
    RepeatedSpeeds,
    /// one more power of the speed
    NextPower,
}

/// What a law's own runs say of it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct LackOfFit {
    /// what it is held against
    pub against: Alternative,
    /// the law against that
    #[serde(flatten)]
    pub test: FTest,
    /// how far the slowest, the middle and the fastest third of the runs would move its parameter
    pub shifts: [f64; PARTS],
}

/// Holds a law of one parameter a group against its rows; `None` where these leave nothing to test it by.
///
/// Speeds count as repeated where at least half of the runs have a neighbour of the same group within 2 %.
pub fn lack_of_fit(rows: &[LawRow]) -> Option<LackOfFit> {
    let mut rows: Vec<LawRow> = rows.iter().filter(|row| row.weight > 0.0).copied().collect();
    rows.sort_by(|a, b| a.group.cmp(&b.group).then(a.speed.total_cmp(&b.speed)));
    let groups = rows.chunk_by(|a, b| a.group == b.group).count();
    let law = Spread {
        sum_of_squares: sum(&rows, |row| row.residual * row.residual),
        runs: rows.len(),
        parameters: groups,
    };
    let speeds = repeated_speeds(&rows);
    let repeats: usize = speeds.iter().filter(|runs| runs.len() > 1).map(|runs| runs.len()).sum();
    let against = if 2 * repeats >= rows.len() && speeds.len() > groups {
        Alternative::RepeatedSpeeds
    } else {
        Alternative::NextPower
    };
    let (sum_of_squares, parameters) = match against {
        Alternative::RepeatedSpeeds => (speeds.iter().map(|runs| about_mean(runs)).sum(), speeds.len()),
        Alternative::NextPower => (law.sum_of_squares - explained(&rows)?, groups + 1),
    };
    let other = Spread {
        sum_of_squares,
        parameters,
        ..law
    };
    let test = nested(law, other)?;
    Some(LackOfFit {
        against,
        test,
        shifts: shifts(rows),
    })
}

fn sum(rows: &[LawRow], of: impl Fn(&LawRow) -> f64) -> f64 {
    rows.iter().map(|row| row.weight * of(row)).sum()
}

/// The rows of each speed; they come by group, then by speed.
fn repeated_speeds(rows: &[LawRow]) -> Vec<&[LawRow]> {
    let mut speeds = vec![];
    let mut start = 0;
    for end in 1..=rows.len() {
        let ends = rows
            .get(end)
            .is_none_or(|next| next.group != rows[start].group || next.speed > rows[start].speed * (1.0 + SAME_SPEED));
        if ends {
            speeds.push(&rows[start..end]);
            start = end;
        }
    }
    speeds
}

/// Squares of the residuals about their mean.
fn about_mean(rows: &[LawRow]) -> f64 {
    let mean = sum(rows, |row| row.residual) / sum(rows, |_| 1.0);
    sum(rows, |row| (row.residual - mean) * (row.residual - mean))
}

/// What one more power of the speed, the same for all groups, explains of the squares; `None` where it is no new column.
fn explained(rows: &[LawRow]) -> Option<f64> {
    /// a column this near to the law's own is not told from it
    const NEW: f64 = 1e-9;
    let (mut own, mut with) = (0.0, 0.0);
    for group in rows.chunk_by(|a, b| a.group == b.group) {
        let along = sum(group, |row| row.next_power * row.slope) / sum(group, |row| row.slope * row.slope);
        let beside = |row: &LawRow| row.next_power - along * row.slope;
        own += sum(group, |row| beside(row) * beside(row));
        with += sum(group, |row| beside(row) * row.residual);
    }
    let whole = sum(rows, |row| row.next_power * row.next_power);
    (own > NEW * whole).then(|| with * with / own)
}

/// How far each third of the runs by speed would move the parameter.
fn shifts(mut rows: Vec<LawRow>) -> [f64; PARTS] {
    rows.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    std::array::from_fn(|part| {
        let of = |part: usize| part * rows.len() / PARTS;
        let third = &rows[of(part)..of(part + 1)];
        sum(third, |row| row.slope * row.residual) / sum(third, |row| row.slope * row.slope)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::dry::speed_root;
    use crate::seed::stream;
    use rand_distr::{Distribution, StandardNormal};

    /// Rows of the first-order law in two groups, at these speeds, with `bend` times one more power in them and normal
    /// noise of 0.01; residuals are those of the law fitted to each group.
    fn rows(name: &str, set: u64, speeds: &[f64], bend: f64) -> Vec<LawRow> {
        let mut rng = stream(0, name, set);
        let mut rows: Vec<LawRow> = vec![];
        for group in 0..2 {
            let mut own: Vec<LawRow> = speeds
                .iter()
                .map(|speed| {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    let root = speed_root(*speed);
                    LawRow {
                        group,
                        speed: *speed,
                        residual: 0.01 * z + bend * root * root,
                        slope: -root,
                        next_power: root * root,
                        weight: 1.0,
                    }
                })
                .collect();
            let shift = sum(&own, |row| row.slope * row.residual) / sum(&own, |row| row.slope * row.slope);
            for row in &mut own {
                row.residual -= shift * row.slope;
            }
            rows.extend(own);
        }
        rows
    }

    const REPEATED: [f64; 12] = [0.4, 0.4, 0.4, 0.8, 0.8, 0.8, 1.3, 1.3, 1.3, 2.0, 2.0, 2.0];
    const SINGLE: [f64; 12] = [0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.15, 1.3, 1.45, 1.6, 1.8, 2.0];

    /// Share of 4000 sets with p below 5 %, in standard errors from 5 %.
    fn alarms(name: &str, speeds: &[f64], bend: f64) -> f64 {
        let sets = 4000u32;
        let found = (0..sets).filter(|set| {
            let tested = lack_of_fit(&rows(name, u64::from(*set), speeds, bend));
            tested.is_some_and(|tested| tested.test.p < 0.05)
        });
        (found.count() as f64 / f64::from(sets) - 0.05) / (0.05 * 0.95 / f64::from(sets)).sqrt()
    }

    #[test]
    fn a_law_that_holds_is_doubted_as_often_as_stated_and_one_that_does_not_is_found() {
        for (name, speeds, against) in [
            ("lack of fit, repeated speeds", REPEATED, Alternative::RepeatedSpeeds),
            ("lack of fit, single speeds", SINGLE, Alternative::NextPower),
        ] {
            let one = lack_of_fit(&rows(name, 0, &speeds, 0.0)).expect("a test");
            assert_eq!(one.against, against);
            let z = alarms(name, &speeds, 0.0);
            assert!(z.abs() < 4.0, "{name}: {z}");
            // the planted fault: a law with one more power
            let z = alarms(name, &speeds, 0.1);
            assert!(z > 40.0, "{name}: {z}");
        }
    }

    #[test]
    fn the_parts_of_a_bent_law_want_other_parameters() {
        let straight = lack_of_fit(&rows("thirds", 0, &REPEATED, 0.0)).expect("a test");
        let bent = lack_of_fit(&rows("thirds", 0, &REPEATED, 0.3)).expect("a test");
        assert!(straight.shifts.iter().all(|shift| shift.abs() < 0.01), "{straight:?}");
        assert!(bent.shifts[0] > 0.02 && bent.shifts[2] < -0.02, "{bent:?}");
    }

    #[test]
    fn runs_that_cannot_tell_give_no_test() {
        // one speed: one more power is the law itself; two runs: nothing is left
        assert_eq!(lack_of_fit(&rows("one speed", 0, &[1.0, 1.0, 1.0], 0.0)), None);
        assert_eq!(lack_of_fit(&rows("two runs", 0, &[1.0], 0.0)), None);
        assert_eq!(lack_of_fit(&[]), None);
    }
}
