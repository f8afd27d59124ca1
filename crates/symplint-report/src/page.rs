//! A report as one page of HTML: no other file, no script, no network.

use std::fmt::Write;

use symplint::evidence::{Point, Sweep};
use symplint::verdict::step_size_text;
use symplint::{Diagnosis, Verdict, VerdictKind};

use crate::provenance::Provenance;
use crate::text::by_label;

const STYLE: &str = include_str!("page.css");

/// A longer report as JSON is not repeated in the page, so that it stays below half a megabyte.
const LONGEST_JSON: usize = 200_000;

/// Rows of the table that are shown at once; the others are folded.
const FIRST_ROWS: usize = 12;

/// What a page shows.
pub struct Page<'a> {
    /// What was tested: `pendulum, strang`.
    pub title: &'a str,
    /// What was found.
    pub diagnosis: &'a Diagnosis,
    /// The figures with their names, as SVG.
    pub figures: &'a [(&'static str, String)],
    /// The configuration as TOML.
    pub config: &'a str,
    /// Where the report comes from.
    pub provenance: &'a Provenance,
    /// The report as JSON.
    pub json: &'a str,
}

impl Page<'_> {
    /// The whole page.
    pub fn to_html(&self) -> String {
        let (title, verdict) = (escaped(self.title), &self.diagnosis.verdict);
        let mut body = header(&title, verdict);
        body += "<main>\n";
        body += &self.sections();
        let _ = write!(
            body,
            "<details><summary>Configuration</summary>\n<pre>{}</pre>\n</details>\n",
            escaped(self.config)
        );
        let Provenance {
            version,
            date,
            seconds,
            threads,
            processor,
            ..
        } = self.provenance;
        let _ = write!(
            body,
            "<details><summary>Provenance</summary>\n<p>symplint {}, {}, {seconds:.1} s on {threads} thread{} of {}.</p>\n</details>\n",
            escaped(version),
            escaped(date),
            if *threads == 1 { "" } else { "s" },
            escaped(processor)
        );
        let json = match self.json.len() <= LONGEST_JSON {
            true => format!("<pre>{}</pre>", escaped(self.json)),
            false => "<p>It is in <code>report.json</code> beside this page.</p>".into(),
        };
        let _ = write!(
            body,
            "<details><summary>All numbers as JSON</summary>\n{json}\n</details>\n</main>\n"
        );
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}: {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n",
            escaped(&verdict.headline())
        )
    }

    /// What a notebook shows: the page without its frame, in the style of the notebook.
    pub fn fragment(&self) -> String {
        let header = header(&escaped(self.title), &self.diagnosis.verdict);
        format!(
            "<div style=\"max-width: 50em\">\n{header}{}</div>\n",
            self.sections()
        )
    }

    fn sections(&self) -> String {
        let verdict = &self.diagnosis.verdict;
        let mut text = format!(
            "<p class=\"summary\">{}</p>\n",
            sentence(&verdict.summary())
        );
        if let Some(cause) = &verdict.cause {
            let setting = cause.setting.as_ref().map_or(String::new(), |setting| {
                format!("<p>Setting to try: <code>{}</code></p>", escaped(setting))
            });
            let _ = write!(
                text,
                "<section class=\"cause\">\n<h2>{}</h2>\n<p>{}</p>{setting}\n</section>\n",
                cause.heading(),
                sentence(&cause.text)
            );
        }
        text += &section("What to do next", &verdict.advice());
        let cards: String = by_label(verdict, true)
            .iter()
            .map(|(title, sentences)| section(title, sentences))
            .collect();
        let _ = write!(text, "<div class=\"cards\">\n{cards}</div>\n");
        for (name, svg) in self.figures {
            let caption = caption(name);
            let _ = write!(
                text,
                "<figure role=\"img\" aria-label=\"{caption}\">\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>\n"
            );
        }
        text + &table(&self.diagnosis.points())
    }
}

/// The band at the top: the answer, what was tested, and what the answer means.
fn header(title: &str, verdict: &Verdict) -> String {
    let (icon, meaning) = match verdict.kind {
        VerdictKind::Symplectic => (
            "✓",
            "On everything that was tried, one step neither adds nor removes phase-space area, to the digits stated.",
        ),
        VerdictKind::NotSymplectic => (
            "✗",
            "A step adds or removes phase-space area, as friction and heating do. Energy need not show it.",
        ),
        VerdictKind::BrokenLoops => (
            "✗",
            "A step is discontinuous: it takes neighbouring states apart, and tears loops of them.",
        ),
        VerdictKind::Undecided => (
            "?",
            "The evidence is not enough for an answer. What to do next is below.",
        ),
    };
    let (kind, headline) = (verdict.kind, sentence(&verdict.headline()));
    format!(
        "<header class=\"{kind}\">\n<h1><span aria-hidden=\"true\">{icon}</span> <span class=\"answer\">{headline}</span></h1>\n<p>{title}</p>\n\
         <p class=\"meaning\">{meaning}</p>\n</header>\n"
    )
}

/// A section of sentences; nothing without sentences.
fn section(title: &str, sentences: &[String]) -> String {
    if sentences.is_empty() {
        return String::new();
    }
    let items: String = (sentences.iter())
        .map(|text| format!("<li>{}</li>\n", sentence(text)))
        .collect();
    format!("<section>\n<h2>{title}</h2>\n<ul>\n{items}</ul>\n</section>\n")
}

fn caption(name: &str) -> &'static str {
    match name {
        "step_sizes" => "The relative change of the loop integral against the step size",
        "samples" => "The same against the number of samples",
        "loop" => "The loop before and after one step",
        _ => "A figure",
    }
}

/// The points of the given loop, and of random ones, as a table; all but the first rows are folded.
fn table(points: &[Point]) -> String {
    let of_sizes: Vec<&Point> = (points.iter())
        .filter(|point| point.sweep == Sweep::StepSize)
        .collect();
    if of_sizes.is_empty() {
        return String::new();
    }
    let has_breaks = of_sizes.iter().any(|point| point.jumps.is_some());
    let breaks = if has_breaks {
        "<th scope=\"col\">breaks</th><th scope=\"col\">change, breaks closed</th>"
    } else {
        ""
    };
    let header = format!(
        "<thead><tr><th scope=\"col\">loop</th><th scope=\"col\">step h</th><th scope=\"col\">samples</th>\
         <th scope=\"col\">change</th><th scope=\"col\">uncertainty</th>{breaks}</tr></thead>"
    );
    let row = |point: &&Point| {
        let name = match point.loop_index {
            0 => "given".to_owned(),
            k => format!("random {k}"),
        };
        let size = match point.step_size.is_finite() {
            true => step_size_text(point.step_size),
            false => "none".into(),
        };
        let uncertainty = point.quadrature_error.map_or("unknown".into(), |error| {
            format!("{:.0e}", error + point.roundoff)
        });
        let mut row = format!(
            "<tr><td>{name}</td><td>{size}</td><td>{}</td><td>{:+.2e}</td><td>{uncertainty}</td>",
            point.samples, point.signed_defect
        );
        if has_breaks {
            let count = point.jumps.map_or(String::new(), |count| count.to_string());
            let closed = (point.closed_defect).map_or(String::new(), |of| format!("{of:.2e}"));
            row += &format!("<td>{count}</td><td>{closed}</td>");
        }
        row + "</tr>\n"
    };
    let of = |points: &[&Point]| -> String {
        let rows: String = points.iter().map(row).collect();
        format!(
            "<div class=\"table\" tabindex=\"0\"><table>\n<caption>Relative change of the loop integral ∮ p·dq in one step</caption>\n\
             {header}\n<tbody>\n{rows}</tbody>\n</table></div>\n"
        )
    };
    let (first, rest) = of_sizes.split_at(of_sizes.len().min(FIRST_ROWS));
    let mut text = of(first);
    if !rest.is_empty() {
        let _ = write!(
            text,
            "<details><summary>{} more rows</summary>\n{}</details>\n",
            rest.len(),
            of(rest)
        );
    }
    text
}

/// A sentence in HTML: exponents are raised, and what stands between backticks is code.
fn sentence(text: &str) -> String {
    let escaped = escaped(text);
    let mut parts = escaped.split('^');
    let mut raised = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = match part.strip_prefix('(') {
            Some(rest) => rest.find(')').map_or(part.len(), |end| end + 2),
            None => {
                let is_of_number = |c: char| c.is_ascii_digit() || c == '-';
                let digits = part.trim_start_matches(is_of_number);
                let fraction = digits.strip_prefix('.').map_or(digits, |rest| {
                    match rest.trim_start_matches(|c: char| c.is_ascii_digit()) {
                        // The end of a sentence.
                        after if after.len() == rest.len() => digits,
                        after => after,
                    }
                });
                part.len() - fraction.len()
            }
        };
        let _ = write!(raised, "<sup>{}</sup>{}", &part[..end], &part[end..]);
    }
    let mut text = String::new();
    for (k, part) in raised.split('`').enumerate() {
        let is_code = k % 2 == 1;
        text += if is_code { "<code>" } else { "" };
        text += part;
        text += if is_code { "</code>" } else { "" };
    }
    text
}

/// A text in HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use symplint::{Circle, Diagnostic, PerSample};

    use super::*;
    use crate::provenance::Run;

    fn page(damping: f64) -> String {
        let map = PerSample::new(1, move |h, q, p| {
            p[0] = (p[0] - h * q[0].sin()) * (1.0 - damping * h);
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.3], vec![0.2], 0.5).unwrap();
        let diagnostic = Diagnostic {
            budget: Some(2000),
            ..Diagnostic::halving(-1, -5)
        };
        let diagnosis = diagnostic.run(&map, &circle).unwrap();
        let figures = [("step_sizes", "<svg></svg>".to_owned())];
        Page {
            title: "a <map> & more",
            diagnosis: &diagnosis,
            figures: &figures,
            config: "[system]\nname = \"it\"",
            provenance: &Run::start("0.1.0", None).provenance(1),
            json: "{}",
        }
        .to_html()
    }

    #[test]
    fn a_page_has_the_answer_its_reasons_and_what_to_do() {
        let page = page(0.1);
        for part in [
            "<header class=\"not-symplectic\">",
            "a &lt;map&gt; &amp; more",
            "<h2>Cause</h2>",
            "uniform friction",
            "<h2>What to do next</h2>",
            "<h2>Jacobian</h2>",
            "<caption>Relative change",
            "name = &quot;it&quot;",
        ] {
            assert!(page.contains(part), "{part}");
        }
        // No other file, and no script.
        for part in ["src=", "href=", "<script", "url("] {
            assert!(!page.contains(part), "{part}");
        }
    }

    #[test]
    fn a_page_of_a_symplectic_map_has_no_cause() {
        let page = page(0.0);
        assert!(page.contains("<header class=\"symplectic\">"));
        assert!(!page.contains("<h2>Cause") && !page.contains("What to do next"));
    }

    #[test]
    fn exponents_are_raised_and_names_of_functions_are_code() {
        for (text, html) in [
            (
                "h from 2^-10 to 2^-1.",
                "h from 2<sup>-10</sup> to 2<sup>-1</sup>.",
            ),
            (
                "as h^(3.0 ± 0.1) or H^0.5: `f`",
                "as h<sup>(3.0 ± 0.1)</sup> or H<sup>0.5</sup>: <code>f</code>",
            ),
            ("a < b", "a &lt; b"),
        ] {
            assert_eq!(sentence(text), html);
        }
    }
}
