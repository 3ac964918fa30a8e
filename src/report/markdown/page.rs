//! Lays out headings, paragraphs, tables and figures in markdown.

/// A markdown text in the making.
pub(in crate::report) struct Page {
    pub(in crate::report) text: String,
    pub(in crate::report) figures: Vec<String>,
}

impl Page {
    pub(in crate::report) fn heading(&mut self, title: &str) {
        self.text.push_str(&format!("## {title}\n\n"));
    }

    pub(in crate::report) fn subheading(&mut self, title: &str) {
        self.text.push_str(&format!("### {title}\n\n"));
    }

    pub(in crate::report) fn paragraph(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push_str("\n\n");
    }

    pub(in crate::report) fn table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        let mut line = |cells: &[String]| {
            self.text.push_str("| ");
            self.text.push_str(&cells.join(" | "));
            self.text.push_str(" |\n");
        };
        line(&header.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>());
        line(&vec!["---".to_owned(); header.len()]);
        for row in rows {
            line(&row.iter().map(|cell| escaped(cell)).collect::<Vec<_>>());
        }
        self.text.push('\n');
    }

    /// Places a figure that was drawn; nothing where figures were not asked for. `short` stands in where it cannot be
    /// shown.
    pub(in crate::report) fn figure(&mut self, name: &str, short: &str, caption: &str) {
        if self.figures.iter().any(|drawn| drawn == name) {
            self.paragraph(&format!("![{short}](figures/{name})\n\n*{caption}*"));
        }
    }
}

/// Keeps a cell one cell.
fn escaped(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
