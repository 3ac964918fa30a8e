//! Bootstraps a group of runs read as `stratum,x,e` lines, with its BCa interval of e_inf, and prints how fast as JSON.
//!
//! Arguments: `linear` or `sqrt`, replicates, threads, repeats (the best counts).

use std::error::Error;
use std::time::Instant;

use wetcor::inference::bootstrap::intervals::Replicates;
use wetcor::inference::bootstrap::jackknife::{acceleration, degrees_of_freedom, influence, leave_one_out};
use wetcor::inference::bootstrap::{replicate, Plan, Pool, Target};
use wetcor::inference::delta::Interval;
use wetcor::inference::law::Law;
use wetcor::inference::regression::Regression;
use wetcor::scene::ResamplingScheme;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let linear = arguments.first().is_some_and(|law| law == "linear");
    let number = |at: usize| -> Result<usize, Box<dyn Error>> {
        let text = arguments.get(at).ok_or("expected law, replicates, threads, repeats")?;
        Ok(text.parse()?)
    };
    let (replicates, threads, repeats) = (number(1)?, number(2)?, number(3)?);
    let mut pool = Pool::default();
    let (mut x, mut e, mut strata) = (vec![], vec![], vec![]);
    for line in std::io::read_to_string(std::io::stdin())?.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let [stratum, abscissa, restitution] = cells[..] else {
            return Err("expected stratum,x,e".into());
        };
        strata.push(stratum.to_owned());
        x.push(abscissa.parse()?);
        e.push(restitution.parse()?);
    }
    for same in strata.chunk_by(|a, b| a == b) {
        let start = pool.strata.last().map_or(0, |last| last.end);
        pool.strata.push(start..start + same.len());
    }
    pool.series.push(0..x.len());
    let regression = Regression::new(if linear { Law::LINEAR } else { Law::SQUARE_ROOT }, &x, &e);
    let fit = regression.fit();
    let target = Target {
        regression,
        strata: 0..pool.strata.len(),
        series: 0..1,
        fitted: [fit.parameters[0], fit.parameters[1]],
        errors: None,
    };
    let e_inf = |p: [f64; 2]| if linear { p[0] } else { p[0].sqrt() };
    let value = e_inf(target.fitted);
    let targets = [target];
    let once = || -> Result<Interval, &'static str> {
        let plan = Plan {
            replicates,
            scheme: ResamplingScheme::Cases,
            seed: 1,
        };
        let (fits, without) = rayon::join(
            || replicate(&pool, &targets, plan, &|_| ()),
            || leave_one_out(&pool, &targets[0], plan.scheme),
        );
        let influences: Vec<Vec<f64>> = without
            .iter()
            .map(|stratum| influence(value, stratum.iter().map(|p| e_inf(*p))))
            .collect();
        let df = degrees_of_freedom(&influences).ok_or("the runs do not vary")?;
        let made = Replicates::new(fits[0].iter().map(|fit| fit.map_or(f64::NAN, e_inf)));
        made.bca(value, acceleration(&influences), 0.95, df)
    };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    // by a thread of the pool: to wake two that sleep takes a third of what the replicates take
    let (best, interval) = threads.install(|| -> Result<_, &'static str> {
        let mut best = f64::INFINITY;
        let mut interval = once()?;
        for _ in 0..repeats {
            let started = Instant::now();
            interval = once()?;
            best = best.min(started.elapsed().as_secs_f64());
        }
        Ok((best, interval))
    })?;
    println!(
        "{{\"seconds\": {best:e}, \"value\": {value}, \"lo\": {}, \"hi\": {}}}",
        interval.lo, interval.hi
    );
    Ok(())
}
