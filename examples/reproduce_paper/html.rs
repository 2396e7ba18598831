//! The page as one HTML file, figures included.

use crate::claims::{Claim, Table};
use crate::page::{Page, TITLE, lines};

const STYLE: &str = "body { font: 16px/1.5 sans-serif; max-width: 62em; margin: 2em auto; padding: \
     0 1em; color: #222 } table { border-collapse: collapse; margin: 1em 0 } th, td { border: 1px \
     solid #bbb; padding: .25em .6em; text-align: left; vertical-align: top } blockquote { margin: \
     1em 0; padding: 0 1em; border-left: 4px solid #bbb; color: #555 } pre { background: #f3f3f3; \
     padding: .6em; overflow-x: auto } img { max-width: 100% }";

/// Writes the whole page.
pub(crate) fn page(page: &Page) -> String {
    let title = escaped(TITLE);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{title}</title>\
         <style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n<pre>{}</pre>\n",
        escaped(&page.command())
    );
    for paragraph in page.introduction() {
        out += &element("p", &paragraph);
    }
    out += &table(&["verdict", "claims", "meaning"], &page.verdicts());
    out += &table(&["claim", "the paper", "ours", "verdict"], &page.summary());
    page.claims.iter().for_each(|c| out += &claim(c));
    out + "</body>\n</html>\n"
}

fn claim(claim: &Claim) -> String {
    let mut out = element("h2", claim.title);
    out += &element("blockquote", &format!("{} ({})", claim.paper_words, claim.place));
    let line = |(head, text): (&str, String)| {
        format!("<li><b>{}:</b> {}</li>", escaped(head), escaped(&text))
    };
    out += "<ul>";
    for item in lines(claim) {
        out += &line(item);
    }
    out += "</ul>\n";
    out += &element("pre", &claim.command);
    claim.notes.iter().for_each(|note| out += &element("p", note));
    if let Some(Table { head, rows }) = &claim.table {
        out += &table(head, rows);
    }
    if let Some(picture) = &claim.picture {
        out += &["<p>", &picture.inline(), "</p>\n"].concat();
    }
    out
}

fn element(name: &str, text: &str) -> String {
    format!("<{name}>{}</{name}>\n", escaped(text))
}

fn table<R: AsRef<[String]>>(head: &[&str], rows: &[R]) -> String {
    let mut out = "<table>\n<tr>".to_owned();
    for cell in head {
        out += &element("th", cell);
    }
    for row in rows {
        out += "</tr>\n<tr>";
        row.as_ref().iter().for_each(|cell| out += &element("td", cell));
    }
    out + "</tr>\n</table>\n"
}

/// Returns a text as HTML shows it.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
