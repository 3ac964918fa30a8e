//! Renders a campaign of falling spheres, to try `track` and `fit` on: `render_campaign FOLDER`.

#[path = "../tests/flight/mod.rs"]
mod flight;
#[path = "../tests/render/campaign.rs"]
mod made;
#[path = "../tests/render/mod.rs"]
mod render;

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(std::io::Error::other("expected a folder to write"));
    };
    std::fs::create_dir_all(&folder)?;
    let runs = made::write(&folder, 1);
    println!(
        "{}: {runs} rendered recordings, recordings.csv and scene.toml",
        folder.display()
    );
    Ok(())
}
