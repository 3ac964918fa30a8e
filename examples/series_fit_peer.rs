//! Times our fit of the runs on standard input, for `benches/peers/series_fit.py`.
//!
//! Input: one `speed,restitution` a line. Output: one line of JSON.

#[path = "../benches/peers/sqrt_law.rs"]
mod sqrt_law;

use std::hint::black_box;
use std::io::BufRead;
use std::time::Instant;

use sqrt_law::SqrtLaw;
use wetcor::inference::least_squares::fit;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut series = SqrtLaw {
        inverse_speeds: vec![],
        restitutions: vec![],
    };
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let (speed, restitution) = line.split_once(',').ok_or("expected speed,restitution")?;
        series.inverse_speeds.push(1.0 / speed.trim().parse::<f64>()?);
        series.restitutions.push(restitution.trim().parse()?);
    }
    let start = [0.7, -0.2];
    let found = fit(&series, &start);
    let (Some(se_alpha), Some(se_beta)) = (found.se(0), found.se(1)) else {
        return Err(format!("no standard errors: {:?}", found.why_no_covariance).into());
    };

    // The best of several batches: the least disturbed by whatever else the machine does.
    let mut seconds_per_fit = f64::INFINITY;
    for _ in 0..10 {
        let (begin, mut fits) = (Instant::now(), 0);
        while begin.elapsed().as_secs_f64() < 0.05 {
            for _ in 0..100 {
                black_box(fit(black_box(&series), black_box(&start)));
            }
            fits += 100;
        }
        seconds_per_fit = seconds_per_fit.min(begin.elapsed().as_secs_f64() / f64::from(fits));
    }
    println!(
        "{{\"seconds_per_fit\": {seconds_per_fit:e}, \"alpha\": {:e}, \"beta\": {:e}, \
         \"se_alpha\": {se_alpha:e}, \"se_beta\": {se_beta:e}}}",
        found.parameters[0], found.parameters[1]
    );
    Ok(())
}
