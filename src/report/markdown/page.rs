//! Lays out headings, paragraphs, lists, tables and figures in markdown.

use super::escape::{destination, guarded};
use super::table::ReportTable;

/// A markdown text in the making.
pub(crate) struct Page {
    pub(crate) text: String,
    pub(crate) figures: Vec<String>,
    /// signs before a heading
    depth: usize,
}

impl Page {
    /// A page under a title that is markdown already.
    pub(crate) fn titled(title: &str, figures: &[&str]) -> Page {
        Page {
            text: format!("# {title}\n\n"),
            figures: figures.iter().map(|name| (*name).to_owned()).collect(),
            depth: 2,
        }
    }

    /// Begins the appendix, of which all that comes after it is a part.
    pub(crate) fn appendix(&mut self) {
        self.heading("Appendix");
        self.depth += 1;
    }

    pub(crate) fn heading(&mut self, title: &str) {
        self.text.push_str(&format!("{} {title}\n\n", "#".repeat(self.depth)));
    }

    /// Begins a section with what it is for.
    pub(crate) fn section(&mut self, title: &str, purpose: &str) {
        self.heading(title);
        self.paragraph(purpose);
    }

    pub(crate) fn subheading(&mut self, title: &str) {
        self.text.push_str(&format!("#{} {title}\n\n", "#".repeat(self.depth)));
    }

    /// Begins a part of a section with what it is for.
    pub(crate) fn subsection(&mut self, title: &str, purpose: &str) {
        self.subheading(title);
        self.paragraph(purpose);
    }

    pub(crate) fn paragraph(&mut self, text: &str) {
        self.text.push_str(&guarded(text));
        self.text.push_str("\n\n");
    }

    /// A list, an entry each.
    pub(crate) fn list(&mut self, entries: &[String]) {
        for entry in entries {
            self.text.push_str(&format!("* {}\n", guarded(entry)));
        }
        if !entries.is_empty() {
            self.text.push('\n');
        }
    }

    pub(crate) fn table<R: Copy>(&mut self, table: &ReportTable<R>) {
        for (number, cells) in table.lines().enumerate() {
            let cells: Vec<String> = cells.into_iter().map(escaped).collect();
            self.text.push_str(&format!("| {} |\n", cells.join(" | ")));
            if number == 0 {
                let rule = vec!["---"; cells.len()];
                self.text.push_str(&format!("| {} |\n", rule.join(" | ")));
            }
        }
        self.text.push('\n');
        if let Some(left_out) = table.left_out() {
            self.paragraph(&left_out);
        }
    }

    /// Places a figure that was drawn and was not placed before. `short` stands in where it cannot be shown.
    pub(crate) fn figure(&mut self, name: &str, short: &str, caption: &str) {
        if let Some(at) = self.figures.iter().position(|drawn| drawn == name) {
            self.figures.remove(at);
            let (short, caption) = (guarded(short), guarded(caption));
            let address = destination(name);
            self.text
                .push_str(&format!("![{short}](figures/{address})\n\n*{caption}*\n\n"));
        }
    }
}

/// Keeps a cell one cell.
fn escaped(text: &str) -> String {
    guarded(text).replace('|', "\\|").replace('\n', " ")
}
