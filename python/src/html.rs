//! Reports as HTML.

use symplint::{Verdict, VerdictKind};
use symplint_report::table::properties;

const STYLE: &str = "body { font-family: sans-serif; max-width: 50em; margin: 2em auto; padding: 0 1em; } \
    pre { overflow-x: auto; }";

/// A page with this title.
pub fn page(title: &str, fragment: &str) -> String {
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n{fragment}</body>\n</html>\n"
    )
}

/// The verdict, its reasons, a figure as SVG and a table.
pub fn fragment(verdict: &Verdict, table: &str, figure: Option<&str>) -> String {
    let color = match verdict.kind {
        VerdictKind::Symplectic => "#1a7f37",
        VerdictKind::NotSymplectic | VerdictKind::BrokenLoops => "#cf222e",
        VerdictKind::Undecided => "#9a6700",
    };
    let mut text = format!(
        "<h3 style=\"color: {color}\">{}</h3>\n<p>{}</p>\n",
        escaped(&verdict.headline()),
        escaped(&verdict.summary())
    );
    for (name, sentences) in [
        ("Evidence", verdict.sentences()),
        ("Properties", properties(verdict).into_iter().collect()),
        ("Advice", verdict.advice()),
    ] {
        if !sentences.is_empty() {
            text += &format!("<h4>{name}</h4>\n<ul>\n");
            for sentence in sentences {
                text += &format!("<li>{}</li>\n", escaped(&sentence));
            }
            text += "</ul>\n";
        }
    }
    if let Some(figure) = figure {
        text += &format!("<div style=\"max-width: 40em\">\n{figure}\n</div>\n");
    }
    text + &format!("<pre>{}</pre>\n", escaped(table))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
