//! Attacks sizes: of files, lines and counts, and numbers of particles.

use crate::common::table_of;
use std::fs::File;
use std::process::Command;

use super::attack::{finish, Outcome, Place};
use wetcor::runs::MOST_SPHERES;

/// Seconds that are plenty for what is refused at once, however busy the machine.
const AT_ONCE: f64 = 10.0;

/// Kilobytes of address space for a command that has no reason to ask for much.
const LITTLE: u64 = 1_500_000;

/// Runs a shell command in the folder, `$WETCOR` being the command, with little memory.
fn shell(place: &Place, command: &str, seconds: f64) -> Outcome {
    let mut shell = Command::new("bash");
    shell
        .current_dir(place.folder.path())
        .env("WETCOR", env!("CARGO_BIN_EXE_wetcor"))
        .args(["-c", &format!("ulimit -v {LITTLE}; {command}")]);
    finish(shell, seconds)
}

fn check(place: &Place) -> Outcome {
    shell(place, "exec $WETCOR check scene.toml", AT_ONCE)
}

/// Has the scene read another table.
fn with_runs(place: &Place, runs: &str) {
    let scene = place.read("scene.toml").replace("runs.csv", runs);
    place.write("scene.toml", scene);
}

#[test]
fn d07_draws_beyond_memory_are_refused_by_their_key() {
    // what fits into a scene may still be too much with its parameters
    let place = Place::plain();
    place.add_to_scene("[sampler]\nchains = 10\ndraws = 1000000");
    let fitted = shell(&place, "exec $WETCOR fit scene.toml --out out --quiet", AT_ONCE);
    fitted.assert_refused(
        "draws times quantities",
        &["[sampler] draws: found 1000000 in 10 chains", "expected at most"],
    );
    assert_eq!(place.entries(), ["runs.csv", "scene.toml"]);
}

#[test]
fn d07_a_design_of_too_many_settings_is_refused_before_it_is_made() {
    let place = Place::plain();
    let many: Vec<String> = (1..=1000).map(|n| format!("{}", f64::from(n) * 1e-3)).collect();
    let many = many.join(", ");
    place.add_to_scene(&format!(
        "[truth]\ndry_k = {{ PTFE = 0.183 }}\nlubrication_log = 1.9\ninertial_prefactor = 0.6\nsigma_dry = 0.01\n\
         sigma_wet = 0.01\n[design]\ndiameter_mm = {{ PTFE = [{many}] }}\nliquids = [\"AK10\"]\n\
         film_ratio = {{ PTFE = [0.03] }}\nimpact_speed_m_s = [{many}, 2]"
    ));
    let simulated = shell(&place, "exec $WETCOR simulate scene.toml --out made.csv", AT_ONCE);
    simulated.assert_refused(
        "settings",
        &["[design]: found 1001000 combinations", "expected at most 1000000"],
    );
    assert_eq!(place.entries(), ["runs.csv", "scene.toml"]);
}

/// Runs of a scene that draws only dry runs, all alike.
const ALIKE: &str = "[truth]\ndry_k = { PTFE = 0.183 }\nsigma_dry = 0.0\nsigma_wet = 0.0\nlubrication_log = 1.9\n\
                     inertial_prefactor = 0.6\n[design]\ndiameter_mm = { PTFE = [4] }\ndry_impact_speed_m_s = [1]";

#[test]
fn sizes_asked_for_have_limits() {
    let place = Place::plain();
    place.add_to_scene(&format!("{ALIKE}\nrepeats = 2000000000000"));
    for [command, key, words] in table_of(
        "calibrate --out page.md --sets 1000000000000 | --sets | 1000000
         calibrate --out page.md --sets 18446744073709551615 | --sets | 1000000
         simulate scene.toml --out made.csv --runs 18446744073709551615 | --runs | 1000000000000
         simulate scene.toml --out made.csv | [design] repeats: found 2000000000000 | at most 1000000000000
         predict report --speed-m-s 1:2:1000000000 | --speed-m-s | COUNT from 2 to 100000",
    ) {
        shell(&place, &format!("exec $WETCOR {command}"), AT_ONCE).assert_refused(command, &[key, words]);
    }
    assert_eq!(place.entries(), ["runs.csv", "scene.toml"]);
}

#[test]
fn a_limit_on_memory_is_told_before_anything_is_begun() {
    let place = Place::plain();
    let words = ["195 MB of address space", "640 MB"];
    shell(&place, "ulimit -v 200000; exec $WETCOR fit scene.toml", AT_ONCE).assert_refused("ulimit -v", &words);
    assert_eq!(place.entries(), ["runs.csv", "scene.toml"]);
    // that much does
    let fit = "ulimit -v 655360; exec $WETCOR fit scene.toml --threads 2 --stages least_squares";
    let outcome = shell(&place, fit, 60.0);
    assert!(matches!(outcome.status, Some(0 | 1)), "{outcome:?}");
}

/// A table of a few hundred kilobytes may hold any number of rows that are alike.
#[test]
#[ignore = "slow: draws ten million runs"]
fn a_model_that_keeps_every_run_has_a_limit_of_rows() {
    let place = Place::plain();
    place.add_to_scene(ALIKE);
    let made = place.run(
        &["simulate", "scene.toml", "--runs", "10000001", "--out", "many.parquet"],
        120.0,
    );
    assert_eq!(made.status, Some(0), "{made:?}");
    assert!(std::fs::metadata(place.path("many.parquet")).is_ok_and(|about| about.len() < 10_000_000));
    with_runs(&place, "many.parquet");
    check(&place).assert_refused(
        "open inertia",
        &["10000001 rows", "expected at most 10000000", "named inertia"],
    );
    place.add_to_scene("[model]\ninertia = \"stepwise\"");
    let few = shell(&place, "exec $WETCOR check scene.toml", 60.0);
    assert_eq!(few.status, Some(0), "{few:?}");
}

#[test]
fn d08_a_device_a_folder_and_a_socket_are_no_tables() {
    for extension in ["csv", "parquet"] {
        for target in ["/dev/zero", "/dev/random", "/dev/null"] {
            let place = Place::plain();
            let link = format!("link.{extension}");
            std::os::unix::fs::symlink(target, place.path(&link)).expect("writable");
            with_runs(&place, &link);
            let words = ["cannot read the runs: found a device, expected a regular"];
            check(&place).assert_refused(target, &words);
        }
        let place = Place::plain();
        with_runs(&place, &format!("folder.{extension}"));
        std::fs::create_dir(place.path(&format!("folder.{extension}"))).expect("writable");
        check(&place).assert_refused("a folder", &["found a folder, expected a regular file or a pipe"]);
        let place = Place::plain();
        let socket = format!("socket.{extension}");
        with_runs(&place, &socket);
        let _socket = std::os::unix::net::UnixListener::bind(place.path(&socket)).expect("a socket");
        check(&place).assert_refused("a socket", &["found a socket, expected a regular file or a pipe"]);
    }
    let place = Place::plain();
    let scene = shell(&place, "exec $WETCOR check /dev/zero", AT_ONCE);
    scene.assert_refused("a scene", &["/dev/zero: cannot read: found a device"]);
}

/// A file of 5 GB that takes no room on the disk: good lines, then nothing but zero bytes.
fn sparse(place: &Place, name: &str, start: &str) {
    place.write(name, start);
    let file = File::options().write(true).open(place.path(name)).expect("writable");
    file.set_len(5 << 30).expect("a sparse file");
}

#[test]
fn d08_sparse_tables_and_scenes_are_refused_without_being_read() {
    let place = Place::plain();
    sparse(&place, "runs.csv", "");
    check(&place).assert_refused(
        "zero bytes",
        &["line 1, the file is binary: found byte 0x00, expected a text file saved as UTF-8"],
    );
    let place = Place::plain();
    sparse(&place, "runs.csv", &place.read("runs.csv"));
    check(&place).assert_refused("zero bytes after runs", &["the file is binary"]);
    let place = Place::plain();
    with_runs(&place, "runs.parquet");
    sparse(&place, "runs.parquet", "PAR1");
    check(&place).assert_refused(
        "sparse Parquet",
        &["not a readable Parquet file: ", "must end with PAR1"],
    );
    // with an end that could be one
    let file = File::options()
        .append(true)
        .open(place.path("runs.parquet"))
        .expect("writable");
    std::io::Write::write_all(&mut &file, b"\x08\0\0\0PAR1").expect("writable");
    let words = ["the file is too large: found 5368709128 bytes, expected at most 2147483648 bytes (2048 MiB)"];
    check(&place).assert_refused("sparse Parquet with a footer", &words);
    let place = Place::plain();
    sparse(&place, "scene.toml", "");
    let words = [
        "scene.toml: 1 problem; nothing was written",
        "expected at most 16777216 bytes (16 MiB)",
    ];
    check(&place).assert_refused("a large scene", &words);
}

#[test]
fn d08_a_pipe_is_read_up_to_a_size_and_never_waited_for_without_a_writer() {
    let place = Place::plain();
    let expected = check(&place);
    assert_eq!(expected.status, Some(0), "{expected:?}");
    std::fs::rename(place.path("runs.csv"), place.path("table.csv")).expect("writable");
    let fifo = |rest: &str| {
        shell(
            &place,
            &format!("rm -f runs.csv; mkfifo runs.csv; {rest}"),
            4.0 * AT_ONCE,
        )
    };
    // a table that comes in two pieces, the first of them late
    let good =
        fifo("(sleep 0.1; head -n 5 table.csv; sleep 0.1; tail -n +6 table.csv) > runs.csv & $WETCOR check scene.toml");
    assert_eq!((good.status, good.out), (Some(0), expected.out.clone()), "{}", good.err);
    fifo("$WETCOR check scene.toml").assert_refused("no writer", &["found a pipe that nobody writes to"]);
    let words = ["the file is too large: found more, expected at most 67108864 bytes (64 MiB)"];
    fifo("yes PTFE,dry,4,,,0.5,0.8 > runs.csv & $WETCOR check scene.toml").assert_refused("without end", &words);
    let scene = shell(
        &place,
        "cp table.csv runs2.csv; $WETCOR check <(yes '# a line')",
        AT_ONCE,
    );
    scene.assert_refused("a scene without end", &["expected at most 16777216 bytes (16 MiB)"]);
}

#[test]
fn d08_long_lines_long_rows_and_many_columns_are_refused_by_line() {
    let good = Place::plain().read("runs.csv");
    let mebi = 1 << 20;
    let header = good.lines().next().expect("a header");
    let row = good.lines().nth(1).expect("a row");
    // short of the limit it is a column that nobody reads
    let noted = |length: usize| format!("{header},note\n{row},x\n{row},{}\n{row},x\n", "x".repeat(length));
    let place = Place::plain();
    place.write("runs.csv", noted(mebi - 100));
    assert_eq!(check(&place).status, Some(0));
    let filled = |rows: usize| format!("{row}\n").repeat(rows);
    let mistakes = "PTFE,dry,4,,,0.5,x\n".repeat(300_000);
    for (table, words) in [
        (
            noted(mebi + 1),
            "line 3: found a longer line, expected lines of at most 1048576 bytes",
        ),
        (format!("{good}{}", "x".repeat(3 * mebi)), "found a longer line"),
        (
            format!("{header}\n{row}\n\"{}", filled(60_000)),
            "line 3, row: found a longer row, expected rows of at most 1048576 bytes; is a quote not closed?",
        ),
        (
            format!("{header}{}\n", ",c".repeat(100_000)),
            "line 1, header: found 100007 columns, expected at most 4096",
        ),
        (
            format!("{header}\n{}{row},8\n", filled(200_000)),
            "line 200002, row: found 8 cells, expected 7 as in the header",
        ),
        (format!("{header}\n{mistakes}"), "300000 problems; and 299980 more"),
    ] {
        let place = Place::plain();
        place.write("runs.csv", table);
        check(&place).assert_refused(words, &words.split("; ").collect::<Vec<&str>>());
    }
}

/// The plain scene with so many particles more, each with three dry runs.
fn with_particles(particles: usize) -> Place {
    let place = Place::plain();
    let (mut scene, mut runs) = (place.read("scene.toml"), place.read("runs.csv"));
    for index in 0..particles {
        scene.push_str(&format!(
            "\n[particles.Q{index}]\ndensity_kg_m3 = 2150\nroughness_um = 5\n"
        ));
        // errors that repeat after many particles, so that no two of these are alike
        let k = 0.12 + 0.05 * (index as f64 * 0.618_034).fract();
        for (run, speed) in [0.5_f64, 1.0, 2.0].into_iter().enumerate() {
            let off = 0.004 * ((3 * index + run) as f64 * 0.754_878).fract();
            let restitution = 1.0 - k * speed.powf(0.2) + off;
            runs.push_str(&format!("Q{index},dry,4,,,{speed},{restitution:.4}\n"));
        }
    }
    place.write("scene.toml", scene);
    place.write("runs.csv", runs);
    place
}

#[test]
fn d09_more_particles_than_are_fitted_together_are_refused_at_once() {
    let most = with_particles(MOST_SPHERES - 1);
    assert_eq!(check(&most).status, Some(0));
    for particles in [MOST_SPHERES, 20_000] {
        let place = with_particles(particles);
        let found = format!(
            "[particles]: found {} particles, each with a k of its own",
            particles + 1
        );
        let words = [
            found.as_str(),
            "expected at most 300, since all k are fitted together: split the scene",
        ];
        for verb in ["check", "fit", "trade"] {
            shell(&place, &format!("exec $WETCOR {verb} scene.toml"), AT_ONCE).assert_refused(verb, &words);
        }
        assert_eq!(place.entries(), ["runs.csv", "scene.toml"]);
    }
}

#[test]
fn d09_more_diameters_than_are_fitted_together_are_refused_at_once() {
    let place = Place::plain();
    place.add_to_scene("[model]\ndry_k = \"diameter\"");
    let mut runs = place.read("runs.csv");
    for index in 0..MOST_SPHERES {
        runs.push_str(&format!("PTFE,dry,{:.3},,,1,0.85\n", 5.0 + 0.02 * index as f64));
    }
    place.write("runs.csv", runs);
    let words = [
        "[model] dry_k: found 301 diameters of particles, each with a k of its own",
        "split the scene",
    ];
    check(&place).assert_refused("diameters", &words);
}
