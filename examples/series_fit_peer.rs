//! Times our fit of the runs on standard input, for `benches/peers/series_fit.py`.
//!
//! Input: one `speed,restitution` a line. Output: one line of JSON.

use std::hint::black_box;
use std::io::BufRead;
use std::time::Instant;

use wetcor::inference::law::Law;
use wetcor::inference::regression::Regression;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut inverse_speed, mut restitution) = (vec![], vec![]);
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let (v, e) = line.split_once(',').ok_or("expected speed,restitution")?;
        inverse_speed.push(1.0 / v.trim().parse::<f64>()?);
        restitution.push(e.trim().parse::<f64>()?);
    }
    let fit = || Regression::new(Law::SQUARE_ROOT, black_box(&inverse_speed), black_box(&restitution)).fit();
    let found = fit();
    let ([alpha, beta], Some(se_alpha), Some(se_beta)) = (&found.parameters[..], found.se(0), found.se(1)) else {
        return Err(format!("no standard errors: {:?}", found.covariance.err()).into());
    };
    // the best of several batches: the least disturbed by whatever else the machine does
    let mut seconds_per_fit = f64::INFINITY;
    for _ in 0..10 {
        let (begin, mut fits) = (Instant::now(), 0);
        while begin.elapsed().as_secs_f64() < 0.05 {
            for _ in 0..100 {
                black_box(fit());
            }
            fits += 100;
        }
        seconds_per_fit = seconds_per_fit.min(begin.elapsed().as_secs_f64() / f64::from(fits));
    }
    println!(
        "{{\"seconds_per_fit\": {seconds_per_fit:e}, \"alpha\": {alpha:e}, \"beta\": {beta:e}, \
         \"se_alpha\": {se_alpha:e}, \"se_beta\": {se_beta:e}}}"
    );
    Ok(())
}
