//! Writes the runs of recordings as a table that a scene can name.

use super::campaign::Outcome;
use crate::error::Error;
use crate::rounding::to_digits;
use crate::scene::DRY;
use crate::units::{micrometres, millimetres};

/// The columns of the table; those of a run are as a table of runs has them.
const COLUMNS: [&str; 11] = [
    "run",
    "particle",
    "liquid",
    "diameter_mm",
    "film_um",
    "impact_speed_m_s",
    "impact_speed_sd_m_s",
    "rebound_speed_m_s",
    "rebound_speed_sd_m_s",
    "speed_correlation",
    "exclude",
];

/// The runs as CSV, a line an impact; a recording that gave none has a line with the reason.
pub fn runs_table(outcomes: &[Outcome]) -> Result<Vec<u8>, Error> {
    let mut lines = vec![COLUMNS.map(str::to_owned).to_vec()];
    for Outcome { recording, tracked, .. } in outcomes {
        let line = |run: String, numbers: [String; 5], exclude: &str| {
            let film = recording.liquid.as_ref().map(|_| shown(micrometres(recording.film)));
            let begin = [
                run,
                recording.particle.clone(),
                recording.liquid.as_deref().unwrap_or(DRY).to_owned(),
                shown(millimetres(recording.diameter)),
                film.unwrap_or_default(),
            ];
            [begin.as_slice(), &numbers, &[exclude.to_owned()]].concat()
        };
        if let Err(reason) = tracked {
            lines.push(line(recording.run.clone(), Default::default(), reason.words()));
        }
        let impacts = tracked.iter().flat_map(|tracked| &tracked.impacts);
        for (place, impact) in impacts.enumerate() {
            let run = match place {
                0 => recording.run.clone(),
                _ => format!("{} rebound {}", recording.run, place + 1),
            };
            let speeds = &impact.speeds;
            let of_rebound = |value: f64| if impact.stuck { String::new() } else { shown(value) };
            let numbers = [
                shown(speeds.impact_speed),
                shown(speeds.impact_speed_sd),
                shown(speeds.rebound_speed),
                of_rebound(speeds.rebound_speed_sd),
                of_rebound(speeds.correlation),
            ];
            lines.push(line(run, numbers, impact.verdict.as_deref().unwrap_or_default()));
        }
    }
    const DOING: &str = "write the runs";
    let mut writer = csv::Writer::from_writer(vec![]);
    for line in lines {
        writer.write_record(line).map_err(Error::internal(DOING))?;
    }
    writer.into_inner().map_err(Error::internal(DOING))
}

/// Ten significant digits: far below any camera's, without the last-digit noise of a change of unit.
fn shown(x: f64) -> String {
    to_digits(x, 10).to_string()
}
