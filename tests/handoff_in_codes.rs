//! Runs the drop tests of the hand-offs in LIGGGHTS, LAMMPS and YADE and compares the rebound with the law; and has files read
//! whose title tries to be code.
//!
//! Debian has all three (`apt-get install liggghts lammps yade`). Where one is missing its test prints SKIPPED, or fails with
//! `WETCOR_CODES_REQUIRED=1`.

use crate::common::{parameters_of, setting, Folder};
use std::io::Write;
use std::process::Command;

use wetcor::findings::predict::PredictedPoint;
use wetcor::handoff::{files, Code, Handoff, HandoffFile};
use wetcor::physics::{DrySpeed, Form, Inertia, Restitution, Setting};

/// How far a measured rebound may lie from the one asked for.
const WITHIN: f64 = 1e-3;

/// A title that tries to leave its comment in every language: it names an encoding in which a new line follows, ends comments,
/// joins lines, opens long texts, names variables and places of templates, and begins a cell with a formula.
const HOSTILE: &str =
    "coding: utf-7 +AAo-open('owned', 'w')+AAo-# \n\r\u{85}\u{2028}open('owned', 'w') */ #error owned \
                       ${owned} $(1/0) \"\"\" ''' {{e}} @(1/0) ,=HYPERLINK(1),=1+1;@SUM(1) & ??/";

/// The same for Python alone, with nothing else that is not text in that encoding.
const UTF_7: &str = "coding: utf-7 +AAo-open('owned', 'w')+AAo-#";

/// A sphere, what wets its plate, and the speeds of its runs.
struct Pair {
    sphere: Sphere,
    wetting: Option<Wetting>,
    speeds: [f64; 2],
    reference: f64,
}

/// Name, density, viscosity and film of a liquid.
#[derive(Clone, Copy)]
struct Wetting {
    liquid: &'static str,
    density: f64,
    viscosity: f64,
    film: f64,
}

const fn wetting(liquid: &'static str, [density, viscosity, film]: [f64; 3]) -> Option<Wetting> {
    Some(Wetting {
        liquid,
        density,
        viscosity,
        film,
    })
}

/// Name, density, k and diameter of a sphere.
#[derive(Clone, Copy)]
struct Sphere(&'static str, f64, f64, f64);

const PTFE: Sphere = Sphere("PTFE", 2150.0, 0.183, 4.762e-3);
const PE: Sphere = Sphere("PE", 940.0, 0.123, 8e-3);

const fn pair(sphere: Sphere, wetting: Option<Wetting>, speeds: [f64; 2], reference: f64) -> Pair {
    Pair {
        sphere,
        wetting,
        speeds,
        reference,
    }
}

/// From high e to one near the threshold, and dry.
const PAIRS: [Pair; 6] = [
    pair(PTFE, wetting("AK10", [930.0, 9.3e-3, 286e-6]), [0.77, 1.72], 1.2),
    pair(PTFE, wetting("M50", [965.0, 48.3e-3, 286e-6]), [0.8, 1.72], 0.85),
    pair(PE, wetting("AK10", [930.0, 9.3e-3, 480e-6]), [0.4, 1.72], 0.6),
    pair(PE, wetting("M50", [965.0, 48.3e-3, 480e-6]), [1.0, 1.72], 1.4),
    pair(PTFE, None, [0.4, 2.0], 1.0),
    pair(PE, None, [0.4, 2.0], 0.5),
];

impl Pair {
    fn named(&self) -> String {
        let liquid = self.wetting.map_or("dry", |wetting| wetting.liquid);
        format!("{} {liquid} at {} m/s", self.sphere.0, self.reference)
    }

    /// The wetted plate. No form reads the roughness here.
    fn wet(&self) -> Option<Setting> {
        let Sphere(_, density, _, diameter) = self.sphere;
        let of = |own: Wetting| setting([density, diameter], [own.density, own.viscosity], own.film);
        self.wetting.map(of)
    }

    /// e of the law; the parameters are about those of the paper.
    fn law(&self, speed: f64) -> f64 {
        let Sphere(_, _, dry_k, _) = self.sphere;
        let Some(setting) = self.wet() else {
            return 1.0 - dry_k * speed.powf(0.2);
        };
        let form = Form::new(Inertia::Saturating, DrySpeed::Reference(2.0));
        Restitution::new(&setting, form, &parameters_of([dry_k, 1.92, 0.41, 0.068])).at(speed)
    }

    /// The files of a fit whose title tries to be code.
    fn files(&self, code: Code) -> Vec<HandoffFile> {
        self.files_of(code, HOSTILE)
    }

    fn files_of(&self, code: Code, title: &str) -> Vec<HandoffFile> {
        let Sphere(particle, density, _, diameter) = self.sphere;
        let [slowest, fastest] = self.speeds;
        let law = |speed: f64| PredictedPoint {
            q50: self.law(speed),
            q05: self.law(speed) - 0.002,
            q95: self.law(speed) + 0.002,
            extrapolated: !(slowest..=fastest).contains(&speed),
        };
        let h: f64 = 1e-4;
        let log_slope = (self.law(self.reference * h.exp()) / self.law(self.reference)).ln() / h;
        let handoff = Handoff {
            title,
            source: "Müller & Huang 2016, energy balance",
            particle,
            density,
            diameter,
            liquid: self.wetting.map_or("dry", |wetting| wetting.liquid),
            wet: self.wet(),
            reference_speed: self.reference,
            law: &law,
            log_slope,
            speeds: Some(self.speeds),
            stokes: None,
            quotable: true,
        };
        files(code, &handoff).unwrap_or_else(|error| panic!("{}: {error}", self.named()))
    }

    /// The reference speed and two others of the runs.
    fn tried(&self) -> [f64; 3] {
        [self.reference, self.speeds[0], self.speeds[1]]
    }
}

/// Whether the program is there; if it must be, its absence fails.
fn is_there(program: &str) -> bool {
    let there = std::env::var_os("PATH")
        .is_some_and(|paths| std::env::split_paths(&paths).any(|folder| folder.join(program).is_file()));
    let required = std::env::var_os("WETCOR_CODES_REQUIRED").is_some_and(|value| value == "1");
    assert!(there || !required, "{program} is not installed, and is required");
    if !there {
        // the macros' output is kept from the terminal where a test passes
        let mut err = std::io::stderr();
        writeln!(err, "SKIPPED: {program} is not installed, its drop tests were not run").expect("it is open");
    }
    there
}

/// The tree of a program in Python, which looks for the encoding of a file in its first two lines; `None` where it is none.
fn tree(folder: &Folder, text: &str) -> Option<String> {
    folder.write("drop.py", text);
    let read = "import ast; print(ast.dump(ast.parse(open('drop.py', 'rb').read())))";
    let output = Command::new("python3").current_dir(folder).args(["-c", read]).output();
    let output = output.expect("python3 can be started");
    let tree = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then_some(tree)
}

#[test]
fn a_title_is_no_code_in_python() {
    if !is_there("python3") {
        return;
    }
    let folder = Folder::new();
    for pair in &PAIRS {
        let trees = ["PTFE", HOSTILE, UTF_7].map(|title| tree(&folder, &pair.files_of(Code::Yade, title)[0].text));
        assert!(trees[0].is_some() && trees.iter().all(|tree| *tree == trees[0]));
    }
    // with the title in the first line it is code; the line of the law is no text in that encoding
    let hostile = &PAIRS[0].files_of(Code::Yade, UTF_7)[0].text;
    let lines: Vec<&str> = hostile.lines().filter(|line| !line.contains("Law: ")).collect();
    let title = lines.iter().find(|line| line.contains("coding: utf-7"));
    let early = format!("{}\n{}\n", title.expect("it is there"), lines.join("\n"));
    assert_ne!(tree(&folder, &early), tree(&folder, hostile));
}

/// A rebound from the plate and one of two spheres, each with the e that was asked for or expected.
struct Rebounds {
    on_plate: f64,
    of_two: f64,
    asked_of_two: f64,
}

/// The rebounds that a program prints, in order.
fn rebounds(command: &mut Command) -> Vec<Rebounds> {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    // e that was asked for, and what was measured
    let both = |line: &str| -> Option<[f64; 2]> {
        let (before, measured) = line.rsplit_once(", e measured ")?;
        let (_, asked) = before.rsplit_once(' ')?;
        Some([asked.parse().ok()?, measured.trim().parse().ok()?])
    };
    let of = |what: &'static str| text.lines().filter(move |line| line.starts_with(what));
    let rebounds = |(plate, pair): (&str, &str)| {
        let ([_, on_plate], [asked_of_two, of_two]) = (both(plate)?, both(pair)?);
        Some(Rebounds {
            on_plate,
            of_two,
            asked_of_two,
        })
    };
    let lines = of("sphere on plate at ").zip(of("two spheres at "));
    let found: Option<Vec<Rebounds>> = lines.map(rebounds).collect();
    let found = found.unwrap_or_default();
    assert!(!found.is_empty(), "{command:?} printed no rebound:\n{text}\n{errors}");
    found
}

/// A program that reads a file by `-in` and variables by `-var`, as LAMMPS and its offspring do.
struct Reader {
    program: &'static str,
    folder: Folder,
}

impl Reader {
    fn new(program: &'static str) -> Option<Reader> {
        is_there(program).then(|| Reader {
            program,
            folder: Folder::new(),
        })
    }

    fn rebounds(&self, file: &HandoffFile, variables: &[(&str, &str)]) -> Rebounds {
        let mut command = Command::new(self.program);
        command.current_dir(&self.folder);
        command.args(["-in", file.name, "-log", "none"]);
        for (name, value) in variables {
            command.args(["-var", name, value]);
        }
        rebounds(&mut command).swap_remove(0)
    }
}

fn assert_near(measured: f64, asked: f64, of: &str) {
    println!("{of}: asked {asked:.5}, got {measured:.5}");
    assert!((measured - asked).abs() < WITHIN, "{of}: asked {asked}, got {measured}");
}

/// Both rebounds of a contact with one e, which is the law's at the reference speed and, of two spheres, at their St.
fn assert_both_near(found: &Rebounds, pair: &Pair, of: &str) {
    let doubled = if pair.wetting.is_some() { 2.0 } else { 1.0 };
    let [on_plate, of_two] = [1.0, doubled].map(|times| pair.law(times * pair.reference));
    assert_near(found.on_plate, on_plate, &format!("{of}, on plate"));
    assert_near(found.of_two, of_two, &format!("{of}, two spheres"));
}

/// Speed, and e of the contact, in the rows that a file's heading has beside the law.
fn rows(text: &str) -> Vec<(String, f64)> {
    let after = text.lines().skip_while(|line| !line.contains("e of this contact"));
    let rows = after.skip(1).take_while(|line| !line.contains("Largest distance"));
    rows.map(|line| {
        let cells: Vec<&str> = line.split_whitespace().collect();
        (cells[1].to_owned(), cells[3].parse().expect("a number"))
    })
    .collect()
}

/// Runs a contact of one e at every speed that is tried, and with each of some variables.
fn holds_constant(reader: &Reader, pair: &Pair, file: &HandoffFile, variables: &[(&str, &str)]) {
    reader.folder.write(file.name, &file.text);
    let (program, named) = (reader.program, pair.named());
    for speed in pair.tried().map(|speed| speed.to_string()) {
        let found = reader.rebounds(file, &[("speed", &speed)]);
        assert_both_near(&found, pair, &format!("{program} hooke, {named}, {speed} m/s"));
    }
    for (name, value) in variables {
        let found = reader.rebounds(file, &[(name, value)]);
        assert_both_near(&found, pair, &format!("{program} {name} {value}, {named}"));
    }
}

/// Runs a velocity-dependent contact at the reference speed, and at every other speed of its table.
fn holds_its_table(reader: &Reader, file: &HandoffFile, named: &str) {
    reader.folder.write(file.name, &file.text);
    let of = format!("{} {}, {named}", reader.program, file.name);
    let two = reader.rebounds(file, &[]);
    assert_near(two.of_two, two.asked_of_two, &format!("{of}, two spheres"));
    let rows = rows(&file.text);
    assert_eq!(rows.len(), 9);
    for (speed, contact) in rows.iter().step_by(2) {
        let measured = reader.rebounds(file, &[("speed", speed)]).on_plate;
        assert_near(measured, *contact, &format!("{of}, {speed} m/s"));
    }
}

#[test]
#[ignore = "slow: runs LIGGGHTS, LAMMPS and YADE"]
fn liggghts_rebounds_as_asked() {
    let Some(reader) = Reader::new("liggghts") else { return };
    for pair in &PAIRS {
        let (files, named) = (pair.files(Code::Liggghts), pair.named());
        holds_constant(&reader, pair, &files[0], &[("model", "hertz"), ("limit", "on")]);
        if let Some(stokes) = files.get(1) {
            holds_its_table(&reader, stokes, &named);
        }
        assert_eq!(files.len(), if pair.wetting.is_some() { 2 } else { 1 });
    }
    // what the correction is for: with the input of limitForce off the limit moves e by hundredths
    let pair = &PAIRS[1];
    let constant = pair.files(Code::Liggghts).swap_remove(0);
    let text = constant.text.replace("jump SELF limit_${limit}", "");
    assert!(text != constant.text);
    let uncorrected = HandoffFile { text, ..constant };
    reader.folder.write(uncorrected.name, &uncorrected.text);
    let off = reader.rebounds(&uncorrected, &[("limit", "on")]).on_plate - pair.law(pair.reference);
    assert!(off > 20.0 * WITHIN, "{off}");
}

#[test]
#[ignore = "slow: runs LIGGGHTS, LAMMPS and YADE"]
fn lammps_rebounds_as_asked() {
    let Some(reader) = Reader::new("lmp") else { return };
    for pair in &PAIRS {
        let (files, named) = (pair.files(Code::Lammps), pair.named());
        holds_constant(&reader, pair, &files[0], &[("contact", "tsuji")]);
        if let Some(viscoelastic) = files.get(1) {
            holds_its_table(&reader, viscoelastic, &named);
        }
        assert_eq!(files.len(), if pair.wetting.is_some() { 1 } else { 2 });
    }
}

#[test]
#[ignore = "slow: runs LIGGGHTS, LAMMPS and YADE"]
fn yade_rebounds_as_asked() {
    if !is_there("yade") {
        return;
    }
    let folder = Folder::new();
    for pair in &PAIRS {
        let file = pair.files(Code::Yade).swap_remove(0);
        folder.write(file.name, &file.text);
        let speeds = pair.tried().map(|speed| speed.to_string());
        // -j1: a sphere is no work for more threads
        let mut command = Command::new("yade");
        command.current_dir(&folder).args(["-j1", "-x", "-n", file.name]);
        let found = rebounds(command.args(&speeds));
        assert_eq!(found.len(), speeds.len());
        for (speed, found) in speeds.iter().zip(&found) {
            assert_both_near(found, pair, &format!("yade, {}, {speed} m/s", pair.named()));
        }
    }
}
