//! A report as one page of HTML: no other file, no script, no network.

mod html;
mod settings;
mod tables;

use std::fmt::Write;

use symplint::{Diagnosis, Verdict, VerdictKind};

use self::html::{escaped, sentence};
use crate::number::in_thousands;
use crate::provenance::Provenance;
use crate::text::{by_label, list_of_properties, summary};

pub use settings::Repeat;

const STYLE: &str = include_str!("page.css");

/// A longer report as JSON is not repeated in the page, so that it stays below half a megabyte.
const MAX_JSON_LENGTH: usize = 200_000;

/// The contents of a page.
pub struct Page<'a> {
    /// The name of the map: `pendulum, strang`.
    pub title: &'a str,
    /// The result.
    pub diagnosis: &'a Diagnosis,
    /// The figures with their names, as SVG.
    pub figures: &'a [(&'static str, String)],
    /// The configuration as TOML.
    pub config: &'a str,
    /// The origin of the report.
    pub provenance: &'a Provenance,
    /// The report as JSON.
    pub json: &'a str,
    /// How a reader repeats the run.
    pub repeat: Repeat<'a>,
}

impl Page<'_> {
    /// The whole page.
    pub fn to_html(&self) -> String {
        let (title, verdict) = (escaped(self.title), &self.diagnosis.verdict);
        let mut body = header(&title, verdict);
        body += "<main>\n";
        body += &self.sections();
        body += "<footer>\n";
        let _ = write!(
            body,
            "<details><summary>Configuration</summary>\n<pre tabindex=\"0\">{}</pre>\n</details>\n",
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
        let again = match self.repeat {
            Repeat::Command(command) => format!("<p>Run it again:</p>\n{}", copied(command)),
            Repeat::Python | Repeat::Files => String::new(),
        };
        let _ = write!(
            body,
            "<details><summary>Provenance</summary>\n<p>symplint {}, {}, {seconds:.1} s on {threads} thread{} of {}.</p>\n{again}</details>\n",
            escaped(version),
            escaped(date),
            if *threads == 1 { "" } else { "s" },
            escaped(processor)
        );
        let json = match self.json.len() <= MAX_JSON_LENGTH {
            true => format!("<pre tabindex=\"0\">{}</pre>", escaped(self.json)),
            false => "<p>They are in <code>report.json</code> next to this page.</p>".into(),
        };
        let _ = write!(
            body,
            "<details><summary>All numbers as JSON</summary>\n{json}\n</details>\n</footer>\n</main>\n"
        );
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}: {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n",
            escaped(&verdict.headline())
        )
    }

    /// The page for a notebook: without its frame, in the style of the notebook.
    pub fn fragment(&self) -> String {
        let header = header(&escaped(self.title), &self.diagnosis.verdict);
        // Figures have the width of the cell, at most: the notebook does not have the style of the page.
        let sections = (self.sections()).replace(
            "<svg role=",
            "<svg style=\"max-width: 100%; height: auto\" role=",
        );
        format!("<div style=\"max-width: 50em\">\n{header}{sections}</div>\n")
    }

    fn sections(&self) -> String {
        let verdict = &self.diagnosis.verdict;
        let mut text = format!("<p class=\"summary\">{}</p>\n", sentence(&summary(verdict)));
        if let Some(cause) = &verdict.cause {
            let setting = cause.setting.as_ref().map_or(String::new(), |setting| {
                format!("<p>Setting to try:</p>\n{}", copied(setting))
            });
            let _ = write!(
                text,
                "<section class=\"cause\">\n<h2>{}</h2>\n<p>{}</p>{setting}\n</section>\n",
                cause.heading(),
                sentence(&cause.text)
            );
        }
        text += &self.next();
        // The number of evaluations stands below the cards.
        let cards: String = (by_label(verdict, true).iter())
            .filter(|(title, _)| *title != "Cost")
            .map(|(title, sentences)| match *title {
                "Also" => section(title, &list_of_properties(verdict)),
                // The cause has its own section.
                _ => {
                    let is_cause = |text: &&String| {
                        (verdict.cause.as_ref()).is_some_and(|of| of.text == **text)
                    };
                    let others = sentences.iter().filter(|text| !is_cause(text));
                    section(title, &others.cloned().collect::<Vec<String>>())
                }
            })
            .collect();
        let _ = write!(text, "<div class=\"cards\">\n{cards}</div>\n");
        let figures: String = (self.figures.iter())
            .map(|(name, svg)| {
                let caption = caption(name);
                let named = format!("<svg role=\"img\" aria-label=\"{caption}\" ");
                let svg = svg.replacen("<svg ", &named, 1);
                format!("<figure>\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>\n")
            })
            .collect();
        let _ = write!(text, "<div class=\"figures\">\n{figures}</div>\n");
        text += &tables::places(self.diagnosis);
        text += &tables::points(&self.diagnosis.points());
        let of = &self.diagnosis.evidence.evaluations;
        if of.made > 0 {
            let (made, budget) = (in_thousands(of.made), in_thousands(of.budget));
            let _ = writeln!(
                text,
                "<p class=\"cost\">{made} evaluations of at most {budget}.</p>"
            );
        }
        text
    }

    /// The advice, with settings that are ready to copy.
    fn next(&self) -> String {
        let verdict = &self.diagnosis.verdict;
        if verdict.advice.is_empty() {
            return String::new();
        }
        let items: String = (verdict.advice.iter())
            .map(|advice| {
                let again = self.repeat.with(advice, self.diagnosis);
                let again = again.map_or(String::new(), |command| copied(&command));
                format!("<li>{}{again}</li>\n", sentence(&advice.to_string()))
            })
            .collect();
        format!(
            "<section class=\"next\">\n<h2>What to do next</h2>\n<ul>\n{items}</ul>\n</section>\n"
        )
    }
}

/// A command that one click selects as a whole.
fn copied(command: &str) -> String {
    format!(
        "<pre class=\"copy\" tabindex=\"0\">{}</pre>\n",
        escaped(command)
    )
}

/// The band at the top: the answer, what was tested, and what the answer means.
fn header(title: &str, verdict: &Verdict) -> String {
    let is_explained = (verdict.cause.as_ref()).is_some_and(|cause| cause.digits.is_some());
    let (icon, meaning) = match verdict.kind {
        VerdictKind::Symplectic => (
            "✓",
            "A step conserves phase-space area to the digits stated, on each loop and step size that was tried.",
        ),
        VerdictKind::NotSymplectic if is_explained => (
            "✗",
            "A step does not conserve ∮\u{a0}p·dq, but it conserves another area. If the setting below is right for your variables, the step is symplectic.",
        ),
        VerdictKind::NotSymplectic => (
            "✗",
            "A step adds or removes phase-space area, as friction and heating do. A plot of the energy may not show it.",
        ),
        VerdictKind::BrokenLoops => (
            "✗",
            "A step is discontinuous: it separates neighbouring states, and breaks closed loops of states.",
        ),
        VerdictKind::Undecided => (
            "?",
            "There is not enough evidence for an answer. The next steps are below.",
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
    let body = match sentences {
        [] => return String::new(),
        [text] => format!("<p>{}</p>", sentence(text)),
        _ => {
            let items = sentences
                .iter()
                .map(|text| format!("<li>{}</li>\n", sentence(text)));
            format!("<ul>\n{}</ul>", items.collect::<String>())
        }
    };
    format!("<section>\n<h2>{title}</h2>\n{body}\n</section>\n")
}

fn caption(name: &str) -> &'static str {
    match name {
        "step_sizes" => "Change of the loop integral against the step size",
        "samples" => "Change of the loop integral against the number of samples",
        "many_steps" => "Change of the loop integral against the number of steps",
        "loop" => "The loop before and after one step",
        _ => "A figure",
    }
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
            repeat: Repeat::Command("symplint check run/config.toml"),
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
}
