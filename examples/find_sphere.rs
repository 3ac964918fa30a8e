//! Prints where the sphere is in the frames of a recording: `find_sphere FOLDER > positions.csv`.

use std::path::PathBuf;
use std::time::Instant;

use wetcor::recordings::frames::find_sphere;

fn main() -> Result<(), String> {
    let path = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .ok_or("expected a folder of frames")?;
    let start = Instant::now();
    let sightings = find_sphere(&path, &|_, _| ())?;
    let seconds = start.elapsed().as_secs_f64();
    println!("frame,x_px,y_px,radius_px,outline_share,scatter_px");
    for one in &sightings.seen {
        println!(
            "{},{:.5},{:.5},{:.5},{:.3},{:.4}",
            one.frame, one.x_px, one.y_px, one.radius_px, one.outline_share, one.scatter_px
        );
    }
    eprintln!(
        "{} frames in {seconds:.3} s; seen in {}; radius {:.3} px, noise {:.2}, contrast {:.1}",
        sightings.frames,
        sightings.seen.len(),
        sightings.radius_px,
        sightings.noise,
        sightings.contrast
    );
    let memory = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    for line in memory.lines().filter(|line| line.starts_with("VmHWM")) {
        eprintln!("{line}");
    }
    Ok(())
}
