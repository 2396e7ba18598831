//! The page as Markdown, with lines of 100 columns where a line may be broken.

use std::fmt::Write;

use crate::claims::{Claim, Table};
use crate::page::{Page, TITLE, lines};

const WIDTH: usize = 100;

/// Writes the whole page.
pub(crate) fn page(page: &Page) -> String {
    let mut out = format!("# {TITLE}\n\n    {}\n", page.command());
    for paragraph in page.introduction() {
        paragraph_to(&mut out, "", &paragraph);
    }
    let verdicts = page.verdicts();
    table_to(&mut out, &["verdict", "claims", "meaning"], &verdicts);
    table_to(&mut out, &["claim", "the paper", "ours", "verdict"], &page.summary());
    for claim in &page.claims {
        claim_to(&mut out, claim);
    }
    out
}

fn claim_to(out: &mut String, claim: &Claim) {
    push(out, format_args!("\n## {}\n", claim.title));
    paragraph_to(out, "> ", &format!("{} ({})", claim.paper_words, claim.place));
    out.push('\n');
    for (head, text) in lines(claim) {
        out.push_str(&wrapped(&format!("**{head}:** {text}"), "* ", "  "));
    }
    push(out, format_args!("\n    {}\n", claim.command));
    for note in &claim.notes {
        paragraph_to(out, "", note);
    }
    if let Some(Table { head, rows }) = &claim.table {
        table_to(out, head, rows);
    }
    if let Some(picture) = &claim.picture {
        push(out, format_args!("\n![{}]({})\n", picture.caption, picture.name));
    }
}

fn paragraph_to(out: &mut String, mark: &str, text: &str) {
    out.push('\n');
    out.push_str(&wrapped(text, mark, mark));
}

/// Breaks a text into lines; the first begins with `first`, the others with `next`.
fn wrapped(text: &str, first: &str, next: &str) -> String {
    let (mut out, mut line) = (String::new(), first.to_owned());
    let mut is_empty = true;
    for word in text.split(' ') {
        // A line that begins with a sign would be a list.
        let breaks = !matches!(word, "-" | "+" | "*" | "=");
        if breaks && !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            out.push_str(&line);
            out.push('\n');
            next.clone_into(&mut line);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    out.push_str(&line);
    out.push('\n');
    out
}

fn table_to<R: AsRef<[String]>>(out: &mut String, head: &[&str], rows: &[R]) {
    push(out, format_args!("\n| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len())));
    for row in rows {
        let cells: Vec<_> = row.as_ref().iter().map(|cell| cell.replace('|', "\\|")).collect();
        push(out, format_args!("| {} |\n", cells.join(" | ")));
    }
}

fn push(out: &mut String, text: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = out.write_fmt(text);
}
