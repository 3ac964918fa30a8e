//! Drafts a scene from a table of runs: its particles and liquids, its columns as far as they can be guessed, and every key.

use super::guess::{
    guess, is_plain_speed, marks_bad_runs, may_hold_films, may_hold_names, may_hold_reasons, may_tell_liquids,
    speaks_of_liquids, Guess, NotGuessed,
};
use super::headers::called::letters;
use super::headers::heights::other_height;
use super::headers::other_quantity;
use super::headers::units::{unit_in_name, unit_of, StatedUnit};
use super::raw_row::{IMPACTS, REBOUNDS};
use super::survey::{LabelledRow, Survey, SurveyedColumn};
use super::words::is_among;
use crate::error::{and_more, is_unseen, plain, quoted};
use crate::scene::{self, name_is_allowed, wrapped, KeyGuide, RunColumn, Section, Without, DRY, FILL_IN, MISSING};

/// A scene that may lack some values, with what to say of it.
#[derive(Debug)]
pub struct Draft {
    /// the scene
    pub text: String,
    /// rows of the table
    pub rows: usize,
    /// the kinds of spheres
    pub particles: Vec<String>,
    /// the liquids; none where every run is dry, or no column is known to say them
    pub liquids: Vec<String>,
    /// whether a column that is not read may say that runs are wet
    pub may_be_wet: bool,
    /// the sheets of a workbook that hold them; empty where the table has no others
    pub sheets: Vec<String>,
    /// what was guessed of its columns and words, each in a sentence
    pub guessed: Vec<String>,
    /// columns that are not used
    pub unused: Vec<String>,
    /// the keys to fill in, with their tables
    pub to_fill_in: Vec<String>,
}

/// How tables mark runs without liquid, in small letters.
const WITHOUT_LIQUID: &str =
    "dry none no nil without air trocken ohne kein keine luft sec sèche sans aucun seco seca sin secco secca \
     asciutto senza n.a n/a w/o";

/// What may stand beside such a word.
const BESIDE: &str =
    "any liquid fluid film oil layer run runs test plate sphere ball surface contact reference impact flüssigkeit öl \
     oel schicht platte lauf liquide huile líquido aceite liquido olio";

/// How they mark runs with liquid.
const WITH_LIQUID: &str = "wet wetted nass feucht benetzt mouillé humide mojado húmedo bagnato";

/// Whether a word of a column of liquids says that there is none: as a whole, up to a remark, and not as a liquid's name that
/// begins like that.
fn is_dry(word: &str) -> bool {
    const BETWEEN: [char; 7] = [' ', '/', '_', '-', '–', '—', '−'];
    let lower = word.trim().to_lowercase();
    // the `dry` of `dry, no oil`
    let first = lower.split([',', ';', ':', '(']).next().unwrap_or_default();
    let first = first.trim().trim_end_matches('.');
    let mut words = first.split(BETWEEN).filter(|word| !word.is_empty());
    // dashes have no words
    is_among(WITHOUT_LIQUID, first)
        || words.next().is_none_or(|first| is_among(WITHOUT_LIQUID, first))
            && words.all(|word| is_among(WITHOUT_LIQUID, word) || is_among(BESIDE, word))
}

/// The one name of all particles, or of all liquids, of a table that names none.
const SPHERE: &str = "sphere";
const LIQUID: &str = "liquid";

/// Which column of runs each column of a table is, and what the scene must say for it.
#[derive(Default)]
struct Naming<'s> {
    places: Vec<(RunColumn, &'s SurveyedColumn)>,
    /// ours = theirs
    columns: Vec<(String, String)>,
    /// our column and its words, theirs = ours, as TOML
    words: Vec<(String, String)>,
    /// our column and its value, as TOML
    constants: Vec<(String, String)>,
    /// a sheet and our column with its value there, as TOML
    sheets: Vec<(String, String)>,
    guessed: Vec<String>,
    unused: Vec<&'s SurveyedColumn>,
    /// whether one of these may say that runs are wet
    may_be_wet: bool,
}

/// Drafts the scene of a table that it is to name `runs`.
pub(super) fn draft(survey: &Survey, runs: &str) -> Draft {
    let mut naming = Naming::of(survey);
    naming.say_what_was_read(survey);
    naming.say_what_labels_leave_out(survey);
    // the `dry` of a sheet `dry May`
    let is_of_dry = |sheet: &str| sheet.split_whitespace().next().is_some_and(is_dry);
    // sheets of one liquid each, or of one kind of sphere
    let is_wet = naming.has(RunColumn::Film) || survey.sheets.iter().any(|sheet| is_of_dry(sheet));
    let by_sheet = match survey.sheets.len() {
        0 | 1 => None,
        _ if is_wet && !naming.has(RunColumn::Liquid) => Some(RunColumn::Liquid),
        _ if !naming.has(RunColumn::Particle) => Some(RunColumn::Particle),
        _ => None,
    };
    let mut particles = naming.names(RunColumn::Particle, survey, by_sheet, |_| false);
    if particles.is_empty() {
        // every cell is empty, which is for the reader to refuse
        particles.push(SPHERE.to_owned());
    }
    let is_dry_here: fn(&str) -> bool = if by_sheet == Some(RunColumn::Liquid) {
        is_of_dry
    } else {
        is_dry
    };
    let liquids = naming.names(RunColumn::Liquid, survey, by_sheet, is_dry_here);
    naming.ask_for_states(survey);
    naming.leave_half_means();
    naming.read_titles(survey);
    naming.leave_rebound_heights();
    naming.ask_for_columns(!liquids.is_empty());
    naming.say_what_is_taken();
    // as many as the reader of runs counts
    let rows = survey.rows + survey.labelled.len() + survey.notes.len();
    let mut text = Text {
        written: intro(runs, rows),
        to_fill_in: naming.to_fill_in(),
    };
    for section in scene::guide() {
        match section.head {
            "[data]" => text.table("[data]", &section, &naming.guessed, |key| {
                naming.line(key, runs, survey)
            }),
            "[particles.NAME]" => text.each(&section, &particles),
            "[liquids.NAME]" if !liquids.is_empty() => text.each(&section, &liquids),
            head => {
                let comment = if section.may_be_empty { "" } else { "# " };
                text.table(&format!("{comment}{head}"), &section, &[], |_| Line::Comment);
            }
        }
    }
    Draft {
        text: text.written,
        rows,
        particles,
        liquids,
        may_be_wet: naming.may_be_wet,
        sheets: survey.sheets.clone(),
        guessed: naming.guessed,
        unused: naming.unused.iter().map(|column| column.name.clone()).collect(),
        to_fill_in: text.to_fill_in,
    }
}

impl<'s> Naming<'s> {
    /// Columns with our names are what they say; the others are guessed in the order they stand, a plain speed last.
    fn of(survey: &'s Survey) -> Naming<'s> {
        let mut naming = Naming::default();
        let mut others = vec![];
        for column in &survey.columns {
            match RunColumn::named(&column.name) {
                Some((of_runs, _)) => naming.places.push((of_runs, column)),
                None => others.push(column),
            }
        }
        others.sort_by_key(|column: &&SurveyedColumn| is_plain_speed(&column.name));
        for column in others {
            let theirs = quoted(&column.name);
            let guess = guess(column, |candidate| !naming.has(candidate));
            match guess.and_then(|guess| unless_a_title_says(&survey.titles, guess)) {
                Ok(guess) => {
                    let name = format!("{}{}", guess.column.base(), guess.unit.suffix);
                    let unit = if guess.is_unit_guessed {
                        ", its unit by the size of its numbers".to_owned()
                    } else if !column.unit.is_empty() {
                        let side = if column.is_unit_above { "above" } else { "below" };
                        format!(", its unit by the row {side}, {}", quoted(&column.unit))
                    } else {
                        String::new()
                    };
                    naming.say(format!("{theirs} is {name}{unit}"));
                    naming.columns.push((name, column.name.clone()));
                    naming.places.push((guess.column, column));
                }
                Err(_) if marks_bad_runs(column) => {
                    let marks: Vec<String> = column.words.iter().map(|word| quoted(word)).collect();
                    let marks = marks.join(" or ");
                    naming.say(format!("{theirs} is exclude: runs marked {marks} are left out"));
                    let exclude = RunColumn::Exclude.base().to_owned();
                    naming.columns.push((exclude, column.name.clone()));
                }
                Err(why) => {
                    let why = why.map(|(of_runs, why)| format!("{theirs} may be {}, {why}", of_runs.base()));
                    naming.guessed.extend(why);
                    if !column.name.is_empty() {
                        naming.unused.push(column);
                    }
                }
            }
        }
        naming
    }

    fn say(&mut self, guessed: String) {
        self.guessed.push(guessed);
    }

    /// Leaves the name of a column to be filled in.
    fn ask_for(&mut self, column: impl Into<String>) {
        self.columns.push((column.into(), FILL_IN.to_owned()));
    }

    fn column(&self, of_runs: RunColumn) -> Option<&'s SurveyedColumn> {
        let mut places = self.places.iter();
        places.find(|(place, _)| *place == of_runs).map(|(_, column)| *column)
    }

    fn has(&self, of_runs: RunColumn) -> bool {
        self.column(of_runs).is_some()
    }

    /// The names of particles or liquids, without ours for runs that are dry: those in the column of them, those of the sheets
    /// where these tell them apart, else one for all runs; none of liquids where every run is dry.
    fn names(
        &mut self,
        of_runs: RunColumn,
        survey: &Survey,
        by_sheet: Option<RunColumn>,
        is_dry: impl Fn(&str) -> bool,
    ) -> Vec<String> {
        let ours = if by_sheet == Some(of_runs) {
            let ours = names_of(&survey.sheets, is_dry);
            for (sheet, name) in &ours {
                self.say(format!("sheet {} is of {} {name}", quoted(sheet), of_runs.base()));
                let value = format!("{{ {} = {} }}", of_runs.base(), text_of(name));
                self.sheets.push((key_of(sheet), value));
            }
            ours
        } else if let Some(column) = self.column(of_runs) {
            let words = self.words_of_names(column);
            let ours = names_of(&words, is_dry);
            let renamed: Vec<_> = ours.iter().filter(|(theirs, ours)| theirs != ours).cloned().collect();
            for (theirs, ours) in &renamed {
                self.say(format!("{} in {} is {ours}", quoted(theirs), quoted(&column.name)));
            }
            if !renamed.is_empty() {
                let words = inline(renamed.iter().map(quoted_pair));
                self.words.push((of_runs.base().to_owned(), words));
            }
            ours
        } else if of_runs == RunColumn::Particle {
            return self.only(of_runs, SPHERE, "all spheres are of one kind");
        } else if self.has(RunColumn::Film) || self.has(RunColumn::FilmRatio) || self.has(RunColumn::Stokes) {
            return self.only(of_runs, LIQUID, "all runs are wet, with one liquid");
        } else {
            self.ask_for_liquids(survey);
            return vec![];
        };
        let ours = ours.into_iter().map(|(_, ours)| ours);
        ours.filter(|name| name != DRY).collect()
    }

    /// One name for every run of a table without a column of names; where one that is not known may have them, that is to be
    /// filled in.
    fn only(&mut self, of_runs: RunColumn, name: &str, then: &str) -> Vec<String> {
        let mut unused = self.unused.iter().copied();
        let may_say = |column: &SurveyedColumn| {
            may_hold_names(column) || of_runs == RunColumn::Liquid && (may_tell_liquids(column) || tells_states(column))
        };
        if let Some(column) = unused.find(|column| may_say(column)) {
            self.say(format!(
                "no column is known to say the {0}: if {1} does, name it and write a table for each of its words; if none does, \
                 move `{0} = {2}` to constants",
                of_runs.base(),
                quoted(&column.name),
                text_of(name),
            ));
            self.ask_for(of_runs.base());
            return vec![name.to_owned()];
        }
        self.constants.push((of_runs.base().to_owned(), text_of(name)));
        self.say(format!("no column says the {}: {then}", of_runs.base()));
        vec![name.to_owned()]
    }

    /// The words of a column of names, without those that mark another one, as the `#PTFE` of a row that is commented out: no
    /// table is written for these, so that their rows are refused.
    fn words_of_names(&mut self, column: &SurveyedColumn) -> Vec<String> {
        let bare = |word: &str| {
            word.trim_start_matches(['#', '*', '%', '!', ';', '/', '†'])
                .trim_start()
                .to_owned()
        };
        let is_marked = |word: &&String| bare(word) != **word && column.words.contains(&bare(word));
        for word in column.words.iter().filter(is_marked) {
            self.say(format!(
                "{} in {} is no name, since {} stands there, too: take its rows out of the table, or mend them",
                quoted(word),
                quoted(&column.name),
                quoted(&bare(word)),
            ));
        }
        column.words.iter().filter(|word| !is_marked(word)).cloned().collect()
    }

    /// Leaves the liquids to be filled in where every row names one and another column says which rows are dry.
    fn ask_for_states(&mut self, survey: &Survey) {
        let is_in_every_row = |column: &SurveyedColumn| {
            let is_dry = |word: &String| is_dry(word);
            column.filled == survey.rows && !column.has_more && !column.words.iter().any(is_dry)
        };
        let liquid = self.column(RunColumn::Liquid).filter(|column| is_in_every_row(column));
        let state = self.unused.iter().copied().find(|column| tells_states(column));
        let Some((liquid, state)) = liquid.zip(state) else {
            return;
        };
        self.say(format!(
            "{0} names a liquid in every row, but {1} says which are dry: write `dry` in {0} there, then name it as `liquid` in columns",
            quoted(&liquid.name),
            quoted(&state.name),
        ));
        self.columns.retain(|(ours, _)| ours != RunColumn::Liquid.base());
        self.ask_for(RunColumn::Liquid.base());
    }

    /// Leaves the column of liquids to be filled in where one that is not known may hold them, or films, or where a title or the
    /// name of a sheet speaks of either.
    fn ask_for_liquids(&mut self, survey: &Survey) {
        let unused = self.unused.iter();
        let wet = unused.filter(|column| may_hold_names(column) || may_hold_films(column));
        let wet: Vec<String> = wet.map(|column| quoted(&column.name)).collect();
        let around = survey.titles.iter().chain(&survey.sheets);
        let said: Vec<String> = around
            .filter(|text| speaks_of_liquids(text))
            .map(|text| quoted(text))
            .collect();
        let liquids =
            "and write a table [liquids.NAME] for each liquid; if every run is dry, take `liquid` out of columns";
        if !wet.is_empty() {
            self.say(format!(
                "no column is known to say the liquid or the film: if {} does, name it `liquid` or `film_um` in columns {liquids}",
                wet.join(" or ")
            ));
        } else if !said.is_empty() {
            self.say(format!(
                "no column says the liquid or the film, but {} may: give `liquid` and `film_um` as columns or constants {liquids}",
                said.join(", ")
            ));
        } else {
            return;
        }
        self.may_be_wet = true;
        self.ask_for(RunColumn::Liquid.base());
    }

    /// Takes no guessed column for the number of averaged runs unless another has their spread, and none for the spread
    /// without that number: `n` may as well count the rows.
    fn leave_half_means(&mut self) {
        let spreads = [RunColumn::RestitutionSdOfRuns, RunColumn::RestitutionSe];
        if self.has(RunColumn::Runs) && spreads.iter().any(|spread| self.has(*spread)) {
            return;
        }
        for of_runs in [RunColumn::Runs].into_iter().chain(spreads) {
            let is_guessed = self.columns.iter().any(|(ours, _)| ours == of_runs.base());
            if is_guessed {
                self.leave(
                    of_runs,
                    "where each row is the mean of several runs, their number goes into `runs`, with the sd of single runs in \
                     `restitution_sd_of_runs` or the standard error of the mean in `restitution_se`",
                );
            }
        }
    }

    /// Does not read a column that was guessed to be one of runs.
    fn leave(&mut self, of_runs: RunColumn, why: &str) {
        let Some(column) = self.column(of_runs) else {
            return;
        };
        let name = quoted(&column.name);
        self.columns.retain(|(_, theirs)| *theirs != column.name);
        self.places.retain(|(place, _)| *place != of_runs);
        self.guessed.retain(|told| !told.starts_with(&format!("{name} is ")));
        self.say(format!("{name} is not read: {why}"));
        self.unused.push(column);
    }

    /// Leaves to be filled in what runs need and nothing gives.
    fn ask_for_columns(&mut self, is_wet: bool) {
        for one_of in [IMPACTS, REBOUNDS] {
            if !one_of.into_iter().any(|column| self.has(column)) {
                self.ask_for(one_of[0].usual_name());
            }
        }
        for (of_runs, is_needed) in [(RunColumn::Diameter, true), (RunColumn::Film, is_wet)] {
            let is_of_it = |name: &str| RunColumn::named(name).is_some_and(|(own, _)| own == of_runs);
            let is_constant = self.constants.iter().any(|(name, _)| is_of_it(name));
            if !is_needed || self.has(of_runs) || is_constant {
                continue;
            }
            // one of the columns of numbers that are not known may be it
            if self.unused.iter().all(|column| column.largest.is_none()) {
                self.constants.push((of_runs.usual_name(), text_of(FILL_IN)));
            } else {
                self.ask_for(of_runs.usual_name());
            }
        }
    }

    /// Says which rows name the columns, and which sheets are read.
    fn say_what_was_read(&mut self, survey: &Survey) {
        if let Some(row) = survey.header.filter(|_| survey.has_titles) {
            let with_units = survey.columns.iter().filter(|column| !column.unit.is_empty());
            let units = match with_units.map(|column| column.is_unit_above).min() {
                Some(false) => ", their units stand below",
                Some(true) => ", their units stand above",
                None => "",
            };
            self.say(format!("row {row} names the columns{units}"));
        }
        if !survey.hidden_columns.is_empty() {
            let hidden = survey.hidden_columns.join(", ");
            self.say(format!(
                "the spreadsheet hides {hidden}: show them and see whether they are meant"
            ));
        }
        if !survey.sheets_left.is_empty() {
            let left = survey.sheets_left.join(", ");
            self.say(format!(
                "runs are read from the sheets in `runs`, and not from {left}; name one there to read it"
            ));
        }
    }

    /// Says which rows are left out by their labels, as the reader of runs leaves them out.
    fn say_what_labels_leave_out(&mut self, survey: &Survey) {
        /// rows that are named
        const NAMED: usize = 5;
        let sheet = |row: &LabelledRow| match &row.sheet {
            Some(sheet) if survey.sheets.len() > 1 => format!("sheet {} ", quoted(sheet)),
            _ => String::new(),
        };
        for (labelled, what) in [
            (
                &survey.labelled,
                "left out, since their labels say mean, total, spread or count of other rows",
            ),
            (
                &survey.notes,
                "no runs, but one cell alone, so to be taken out of the table",
            ),
        ] {
            let named = labelled.iter().take(NAMED);
            let rows: Vec<String> = named
                .map(|row| format!("{}row {} {}", sheet(row), row.line, quoted(&row.label)))
                .collect();
            if !rows.is_empty() {
                let rows = and_more(rows, labelled.len(), ", ");
                self.say(format!("{what}: {rows}"));
            }
        }
    }

    /// Takes a diameter that a title states, where no column has it.
    fn read_titles(&mut self, survey: &Survey) {
        if self.has(RunColumn::Diameter) {
            return;
        }
        let mut titles = survey.titles.iter();
        if let Some((title, (name, value))) = titles.find_map(|title| Some((title, diameter_in(title)?))) {
            self.say(format!("{name} is {value}, by {}", quoted(title)));
            self.constants.push((name, value));
        }
    }

    /// Leaves a rebound height where another column says the same of as many runs: a ruler is too coarse to agree with it.
    fn leave_rebound_heights(&mut self) {
        let better = [RunColumn::Restitution, RunColumn::ReboundSpeed];
        let better = better.into_iter().max_by_key(|of_runs| self.filled(*of_runs));
        let Some(better) = better.and_then(|of_runs| self.column(of_runs)) else {
            return;
        };
        let is_better = better.filled > 0 && better.filled >= self.filled(RunColumn::ReboundHeight);
        let height = self.column(RunColumn::ReboundHeight);
        // a column with our name is what it says
        let is_guessed = |height: &SurveyedColumn| self.columns.iter().any(|(_, theirs)| *theirs == height.name);
        if is_better && height.is_some_and(is_guessed) {
            let why = format!("{} says the same of more runs", quoted(&better.name));
            self.leave(RunColumn::ReboundHeight, &why);
        }
    }

    /// Cells of a column that are not empty.
    fn filled(&self, of_runs: RunColumn) -> usize {
        self.column(of_runs).map_or(0, |column| column.filled)
    }

    /// Whether heights give speeds that no other column gives, or a header says of what or above what they are.
    fn needs_heights(&self) -> bool {
        let rebound = self
            .filled(RunColumn::ReboundSpeed)
            .max(self.filled(RunColumn::Restitution));
        let usual = scene::Naming::default();
        let heights = [RunColumn::DropHeight, RunColumn::ReboundHeight];
        let says = |of: &RunColumn| {
            self.column(*of)
                .is_some_and(|column| other_height(&column.name, "its name", *of, &usual).is_some())
        };
        self.filled(RunColumn::DropHeight) > self.filled(RunColumn::ImpactSpeed)
            || self.filled(RunColumn::ReboundHeight) > rebound
            || heights.iter().any(says)
    }

    /// Says what a name leaves open: which Stokes number, and which column may say what to leave out.
    fn say_what_is_taken(&mut self) {
        if let Some(column) = self.column(RunColumn::Stokes) {
            self.say(format!("{} is ρp D v/(9 η), with the 9", quoted(&column.name)));
        }
        let reasons = self.unused.iter().filter(|column| may_hold_reasons(&column.name));
        let of_reasons: Vec<String> = reasons
            .map(|column| {
                if let Some(why) = other_quantity(&column.name, RunColumn::Exclude, "exclude") {
                    return format!("{} is not read: {why}", quoted(&column.name));
                }
                let name = text_of(&column.name);
                format!(
                    "{} is not read: if it says which runs to leave out, add `exclude = {name}` to columns, and every run with a \
                     word there is left out (where all its words say yes or no, those with a yes)",
                    quoted(&column.name)
                )
            })
            .collect();
        self.guessed.extend(of_reasons);
    }

    /// The columns and constants to fill in, with their tables.
    fn to_fill_in(&self) -> Vec<String> {
        let columns = self.columns.iter().filter(|(_, theirs)| theirs == FILL_IN);
        let columns = columns.map(|(ours, _)| format!("[data] columns.{ours}"));
        let constants = self.constants.iter().filter(|(_, value)| *value == text_of(FILL_IN));
        columns
            .chain(constants.map(|(ours, _)| format!("[data] constants.{ours}")))
            .collect()
    }

    /// What stands on the line of a key of the data.
    fn line(&self, key: &KeyGuide, runs: &str, survey: &Survey) -> Line {
        let value = match (key.base, survey.header) {
            ("runs", _) => tables(runs, &survey.sheets),
            ("columns", _) => inline(self.columns.iter().map(quoted_pair)),
            ("values", _) => inline(self.words.iter().cloned()),
            ("constants", _) => inline(self.constants.iter().cloned()),
            ("sheets", _) => inline(self.sheets.iter().cloned()),
            ("header_row", Some(row)) if survey.has_titles => row.to_string(),
            ("heights_to" | "heights_of", _) if self.needs_heights() => return Line::ToFillIn,
            ("hidden_rows", _) if survey.hidden_rows > 0 => return Line::ToFillIn,
            _ => return Line::Comment,
        };
        match value.is_empty() {
            true => Line::Comment,
            false => Line::Value(value),
        }
    }
}

/// The scene as it is written.
struct Text {
    written: String,
    to_fill_in: Vec<String>,
}

/// What stands on the line of a key.
enum Line {
    /// this value
    Value(String),
    /// a mark, to be replaced
    ToFillIn,
    /// a comment: its default or an example
    Comment,
}

fn intro(runs: &str, rows: usize) -> String {
    format!(
        "# A scene for wetcor, drafted from {} of {rows} rows.\n\
         # Replace every {}; a key behind a # shows its default, or an example where it has none.\n\
         # `wetcor check` says what is missing still, `wetcor help scene` what a key takes.\n",
        plain(runs, usize::MAX),
        text_of(FILL_IN),
    )
}

impl Text {
    /// A table for each of some names.
    fn each(&mut self, section: &Section, names: &[String]) {
        for name in names {
            let head = section.head.replace("NAME", &key_of(name));
            self.table(&head, section, &[], |key| match key.without {
                Without::Refused => Line::ToFillIn,
                _ => Line::Comment,
            });
        }
    }

    /// A table with what was guessed, and with its keys, each with what stands on its line.
    fn table(&mut self, head: &str, section: &Section, guessed: &[String], line: impl Fn(&KeyGuide) -> Line) {
        let about = wrapped(&format!("{}.", section.about), "# ");
        let blank = if head.is_empty() { "" } else { "\n" };
        self.written.push_str(&format!("\n{about}\n{head}{blank}"));
        for guessed in guessed {
            self.written.push_str(&format!("# guessed: {guessed}\n"));
        }
        for key in &section.keys {
            self.key(head, key, &line(key));
        }
    }

    fn key(&mut self, head: &str, key: &KeyGuide, line: &Line) {
        /// where comments start, as far as keys leave room
        const WIDTH: usize = 44;
        let name = key.usual_name();
        let code = match line {
            Line::Value(value) => format!("{name} = {value}"),
            Line::ToFillIn => format!("{name} = {}", text_of(FILL_IN)),
            Line::Comment => format!("# {name} = {}", key.usual_value()),
        };
        let without = match (&key.without, line) {
            (Without::Words(words), Line::Comment) => format!("; without it: {words}"),
            _ => String::new(),
        };
        let is_long = code.chars().count() > WIDTH;
        self.written.push_str(&match line {
            // above it stands what was guessed
            Line::Value(_) if is_long => format!("{code}\n"),
            _ => format!("{code:WIDTH$}  # {}{without}\n", key.meaning),
        });
        if matches!(line, Line::ToFillIn) {
            self.to_fill_in.push(format!("{head} {name}"));
        }
    }
}

/// Whether a column says of each run whether it is dry or wet.
fn tells_states(column: &SurveyedColumn) -> bool {
    let says_wet = |word: &str| is_among(WITH_LIQUID, &word.trim().to_lowercase());
    let name = letters(&column.name);
    let is_called = says_wet(&name) || is_among("dry trocken", &name);
    let are_states = || {
        let mut words = column.words.iter();
        words.clone().any(|word| says_wet(word)) && words.all(|word| says_wet(word) || is_dry(word))
    };
    column.words.len() >= 2 && !column.has_more && (is_called && column.words.len() == 2 || are_states())
}

/// The names of a particle or liquid that words stand for, each with its word; a dry run is ours.
fn names_of(words: &[String], is_dry: impl Fn(&str) -> bool) -> Vec<(String, String)> {
    let mut names: Vec<(String, String)> = vec![];
    for word in words {
        if is_dry(word) {
            names.push((word.clone(), DRY.to_owned()));
            continue;
        }
        let mut name: String = word
            .chars()
            .map(|c| if name_is_allowed(&c.to_string()) { c } else { '_' })
            .collect();
        while names.iter().any(|(_, other)| *other == name) || name == MISSING || name == DRY {
            name.push('_');
        }
        names.push((word.clone(), name));
    }
    names
}

/// A guess, unless its unit goes by the size of numbers and a title speaks of another one.
fn unless_a_title_says(titles: &[String], guess: Guess) -> Result<Guess, Option<NotGuessed>> {
    let dimension = guess.column.dimension();
    let is_another = |unit: StatedUnit| match unit {
        StatedUnit::Ours(suffix) => suffix != guess.unit.suffix && dimension.unit(suffix).is_some(),
        StatedUnit::Other(_) => true,
    };
    let mut titles = titles.iter().filter(|_| guess.is_unit_guessed);
    match titles.find(|title| unit_in_name(title, dimension).is_some_and(is_another)) {
        Some(title) => Err(Some((guess.column, format!("but {} may say its unit", quoted(title))))),
        None => Ok(guess),
    }
}

/// A diameter that a title states as `D = 4,762 mm`: our name of it, and its value.
fn diameter_in(title: &str) -> Option<(String, String)> {
    /// other things that have one
    const OTHERS: &str = "plate platte beam strahl hole dish schale lens tube rohr magnet nozzle düse";
    let lower = title.to_lowercase();
    let mut words = lower.split(|c: char| !c.is_alphanumeric());
    if words.any(|word| is_among(OTHERS, word)) {
        return None;
    }
    let after = ["d =", "d=", "durchmesser", "diameter", "dia.", "ø", "∅"]
        .iter()
        .find_map(|word| {
            let at = lower.find(word)?;
            // the d of `end = 4`
            let is_word = !lower[..at].ends_with(char::is_alphanumeric);
            is_word.then(|| lower[at + word.len()..].trim_start_matches([' ', '=', ':']))
        })?;
    let end = after.find(|c: char| !(c.is_ascii_digit() || ".,".contains(c)))?;
    let value: f64 = after[..end].replace(',', ".").parse().ok()?;
    let unit: String = after[end..]
        .trim_start()
        .chars()
        .take_while(|c| c.is_alphabetic())
        .collect();
    let StatedUnit::Ours(suffix) = unit_of(&unit)? else {
        return None;
    };
    let name = format!("{}{suffix}", RunColumn::Diameter.base());
    RunColumn::named(&name).filter(|(column, _)| *column == RunColumn::Diameter && value > 0.0)?;
    Some((name, value.to_string()))
}

/// The tables of runs as TOML: one, or a sheet of a workbook after the other.
fn tables(runs: &str, sheets: &[String]) -> String {
    let named: Vec<String> = sheets.iter().map(|sheet| text_of(&format!("{runs}#{sheet}"))).collect();
    match named.as_slice() {
        [] => text_of(runs),
        [only] => only.clone(),
        several => format!("[{}]", several.join(", ")),
    }
}

fn quoted_pair((key, value): &(String, String)) -> (String, String) {
    (key_of(key), text_of(value))
}

/// Keys and values as a table on one line; nothing where there are none.
fn inline(pairs: impl Iterator<Item = (String, String)>) -> String {
    let pairs: Vec<String> = pairs.map(|(key, value)| format!("{key} = {value}")).collect();
    if pairs.is_empty() {
        String::new()
    } else {
        format!("{{ {} }}", pairs.join(", "))
    }
}

/// A text as TOML has it.
fn text_of(text: &str) -> String {
    let mut written = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => written.extend(['\\', c]),
            c if is_unseen(c) => written.push_str(&format!("\\U{:08X}", u32::from(c))),
            c => written.push(c),
        }
    }
    written.push('"');
    written
}

/// A key as TOML has it, in quotes where it needs them.
fn key_of(name: &str) -> String {
    let is_bare = !name.is_empty()
        && name
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    if is_bare {
        name.to_owned()
    } else {
        text_of(name)
    }
}
