//! Lays out headings, paragraphs, lists, tables and figures in markdown.

use super::escape::{destination, guarded};

/// A markdown text in the making.
pub(crate) struct Page {
    pub(crate) text: String,
    pub(crate) figures: Vec<String>,
}

impl Page {
    /// A page under a title that is markdown already.
    pub(crate) fn titled(title: &str, figures: &[&str]) -> Page {
        Page {
            text: format!("# {title}\n\n"),
            figures: figures.iter().map(|name| (*name).to_owned()).collect(),
        }
    }

    pub(crate) fn heading(&mut self, title: &str) {
        self.text.push_str(&format!("## {title}\n\n"));
    }

    pub(crate) fn subheading(&mut self, title: &str) {
        self.text.push_str(&format!("### {title}\n\n"));
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

    pub(crate) fn table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        let mut line = |cells: &[String]| {
            self.text.push_str("| ");
            self.text.push_str(&cells.join(" | "));
            self.text.push_str(" |\n");
        };
        line(&header.iter().map(|cell| escaped(cell)).collect::<Vec<_>>());
        line(&vec!["---".to_owned(); header.len()]);
        for row in rows {
            line(&row.iter().map(|cell| escaped(cell)).collect::<Vec<_>>());
        }
        self.text.push('\n');
    }

    /// Places a figure that was drawn; nothing where figures were not asked for. `short` stands in where it cannot be
    /// shown.
    pub(crate) fn figure(&mut self, name: &str, short: &str, caption: &str) {
        if self.figures.iter().any(|drawn| drawn == name) {
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
