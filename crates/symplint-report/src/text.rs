//! A diagnosis as text, to be read on one screen.

use comfy_table::{CellAlignment, Table, TableStyle};
use symplint::evidence::{Origin, Point, Sweep};
use symplint::rules::RuleKind;
use symplint::verdict::{Property, plain_numbers, step_size_text};
use symplint::{Diagnosis, Verdict};

use crate::number::in_thousands;
use crate::wrap::wrapped;

/// How a diagnosis is shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct DisplayOptions {
    /// Characters of a line; without a width, paragraphs stay on one line each.
    pub width: Option<usize>,
    /// Every step size and every finding, instead of what fits one screen.
    pub all: bool,
}

/// Characters before the text of a finding: the label has ten at most.
const COLUMN: usize = 14;

/// Rows of a sweep that are shown: two, and the last one.
const FEW_ROWS: usize = 4;

/// A change of more times its uncertainty is written with a sign and two digits. That of a verdict.
const SIGNIFICANT: f64 = 10.0;

/// The headline of a verdict with the answer in capitals: the answer, and the rest.
pub fn headline(verdict: &Verdict) -> (String, String) {
    let (words, headline) = (verdict.kind.words(), verdict.headline());
    let rest = headline.strip_prefix(words).unwrap_or(&headline);
    (words.to_uppercase(), rest.to_owned())
}

/// The summary of a verdict without the law of the change, which the headline names.
pub fn summary(verdict: &Verdict) -> String {
    const LAW: &str = " in proportion to ";
    let (headline, summary) = (verdict.headline(), verdict.summary());
    match headline.split_once(LAW) {
        Some((_, law)) => summary.replace(&format!(",{LAW}{law}"), ""),
        None => summary,
    }
}

/// What stands below the headline of a verdict: its summary, the title, a table of the given loop, and the findings by subject.
pub fn diagnosis_text(title: &str, diagnosis: &Diagnosis, shown: DisplayOptions) -> String {
    let verdict = &diagnosis.verdict;
    let mut text = wrapped("", "", &summary(verdict), shown.width);
    text += &format!("\n{title}\n");
    text += &tables(diagnosis, shown.all);
    text += &format!("\n{}", findings(verdict, shown));
    let of = &diagnosis.evidence.evaluations;
    if of.made > 0 {
        let (made, budget) = (in_thousands(of.made), in_thousands(of.budget));
        text += &format!("\n\n  {made} evaluations of at most {budget}.");
    }
    text
}

/// The summary and the findings of a verdict.
pub fn reasons(verdict: &Verdict, shown: DisplayOptions) -> String {
    let summary = wrapped("", "", &verdict.summary(), shown.width);
    format!("{summary}\n\n{}", findings(verdict, shown))
}

/// The findings after the first, and the properties, by label: in the order of the first of each label, with what was not tested and
/// the cost at the end. Without `all`, those that repeat others or the cause are left out.
pub fn by_label(verdict: &Verdict, all: bool) -> Vec<(&'static str, Vec<String>)> {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    let mut add = |label, text| match groups.iter_mut().find(|(of, _)| *of == label) {
        Some((_, texts)) => texts.push(text),
        None => groups.push((label, vec![text])),
    };
    let mut orders: Vec<f64> = Vec::new();
    for finding in verdict.findings.iter().skip(1) {
        let label = finding.label();
        // The table has the bounds, and one law stands for others of its order.
        let order = finding.law().map(|fit| fit.slope.round());
        let is_repeated = finding.is_bound() || order.is_some_and(|order| orders.contains(&order));
        orders.extend(order);
        let text = finding.to_string();
        let is_cause = verdict.cause.as_ref().is_some_and(|of| of.text == text);
        if all || !(is_repeated || is_cause) {
            add(label, text);
        }
    }
    if let Some(properties) = properties(verdict) {
        add("Also", properties);
    }
    groups.sort_by_key(|(label, _)| match *label {
        "Not tested" => 1,
        "Cost" => 2,
        _ => 0,
    });
    groups
}

/// The cause, the findings by label, and what to do next.
fn findings(verdict: &Verdict, shown: DisplayOptions) -> String {
    let cause = (verdict.cause.iter()).map(|cause| (cause.heading(), vec![cause.text.clone()]));
    let found = by_label(verdict, shown.all).into_iter();
    // The number of evaluations stands at the end.
    let found = found.filter(|(label, _)| *label != "Cost");
    let advice = verdict.advice();
    let next = (!advice.is_empty()).then_some(("Next", advice));
    let groups: Vec<(&str, Vec<String>)> = cause.chain(found).chain(next).collect();
    let indent = " ".repeat(COLUMN);
    let lines = groups.iter().flat_map(|(label, texts)| {
        let labels = std::iter::once(*label).chain(std::iter::repeat(""));
        labels.zip(texts).map(|(label, text)| {
            let first = format!("  {label:<width$}", width = COLUMN - 2);
            wrapped(&first, &indent, text, shown.width)
        })
    });
    lines.collect::<Vec<String>>().join("\n")
}

/// The properties of the map that do not follow from the verdict, as one sentence, if there are any.
pub fn properties(verdict: &Verdict) -> Option<String> {
    let texts = list_of_properties(verdict);
    (!texts.is_empty()).then(|| texts.join(", "))
}

/// The properties of the map that do not follow from the verdict.
pub(crate) fn list_of_properties(verdict: &Verdict) -> Vec<String> {
    let properties = (verdict.properties.iter()).filter(|property| !property.implied);
    properties.map(Property::to_string).collect()
}

/// The sweeps of the given loop, one table for each rule.
fn tables(diagnosis: &Diagnosis, all: bool) -> String {
    let points = diagnosis.points();
    let of_files = diagnosis.evidence.origin == Origin::Samples;
    let mut text = String::new();
    for sweep in [Sweep::StepSize, Sweep::Samples] {
        let mut rules: Vec<(RuleKind, Vec<&Point>)> = Vec::new();
        for point in (points.iter()).filter(|of| of.sweep == sweep && of.loop_index == 0) {
            match rules.iter_mut().find(|(rule, _)| *rule == point.rule) {
                Some((_, points)) => points.push(point),
                None => rules.push((point.rule, vec![point])),
            }
        }
        for (rule, points) in rules {
            let has_step_size = of_files || points.iter().any(|of| !of.step_size.is_nan());
            let step = match (of_files, has_step_size) {
                (false, true) => " in one step",
                (false, false) => " by the map",
                (true, _) => "",
            };
            text += &format!("\n  Relative change of ∮p·dq{step} ({rule} rule)\n");
            text += &table(&points, has_step_size, all);
        }
    }
    text
}

/// One sweep, with a column of step sizes unless the map has none.
fn table(points: &[&Point], has_step_size: bool, all: bool) -> String {
    let omitted = points.iter().any(|point| point.omitted_cells.is_some());
    let breaks = points.iter().any(|point| point.jumps.is_some());
    let mut header = vec!["step h", "samples", "change", "uncertainty"];
    if omitted {
        header.push("omitted cells");
    }
    if breaks {
        header.extend(["breaks", "closed"]);
    }
    let without = usize::from(!has_step_size);
    header.drain(..without);
    let row = |point: &Point| {
        let count = |count: Option<usize>| count.map_or(String::new(), |count| count.to_string());
        let mut row = vec![
            step_size(point.step_size),
            point.samples.to_string(),
            change(point),
            uncertainty(point).map_or("?".into(), |error| number(error, 0)),
        ];
        if omitted {
            row.push(count(point.omitted_cells));
        }
        if breaks {
            row.push(count(point.jumps));
            row.push(
                point
                    .closed_defect
                    .map_or(String::new(), |defect| number(defect, 0)),
            );
        }
        row.drain(..without);
        row
    };
    let is_few = all || points.len() <= FEW_ROWS;
    let is_quiet = points
        .iter()
        .all(|point| is_within(point) && point.jumps.is_none());
    let mut rows: Vec<Vec<String>> = match (is_few, is_quiet) {
        (true, _) => points.iter().map(|point| row(point)).collect(),
        (false, true) => points[..2].iter().map(|point| row(point)).collect(),
        (false, false) => {
            let mut between = vec![String::new(); header.len()];
            between[0] = "⋮".into();
            let first = points[..2].iter().map(|point| row(point));
            first
                .chain([between])
                .chain(points.last().map(|point| row(point)))
                .collect()
        }
    };
    rows.insert(0, header.into_iter().map(str::to_owned).collect());
    let mut table = Table::new();
    table.load_style(TableStyle::new());
    table.add_rows(rows);
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut text = String::new();
    for line in table.trim_fmt().lines() {
        text += &format!("    {line}\n");
    }
    if !is_few && is_quiet {
        let others = points.len() - 2;
        text += &format!("      ⋮  {others} more, none above its uncertainty (--all)\n");
    }
    text
}

/// Quadrature error and round-off of a change, if they are known.
fn uncertainty(point: &Point) -> Option<f64> {
    point.quadrature_error.map(|error| error + point.roundoff)
}

fn is_within(point: &Point) -> bool {
    uncertainty(point).is_some_and(|error| point.signed_defect.abs() <= SIGNIFICANT * error)
}

/// A change, signed unless it is within its uncertainty.
fn change(point: &Point) -> String {
    match is_within(point) {
        true => number(point.signed_defect.abs(), 0),
        false => plain_numbers(&format!("{:+.1e}", point.signed_defect)),
    }
}

/// A number with `decimals` decimals, or 0.
fn number(value: f64, decimals: usize) -> String {
    match value == 0.0 {
        true => "0".into(),
        false => plain_numbers(&format!("{value:.decimals$e}")),
    }
}

/// A step size; a loop from a file may not state it.
fn step_size(h: f64) -> String {
    match h.is_nan() {
        true => "?".into(),
        false => step_size_text(h),
    }
}

#[cfg(test)]
mod tests {
    use symplint::{Circle, Diagnostic, PerSample};

    use super::*;

    fn diagnosed(friction: f64) -> Diagnosis {
        let map = PerSample::new(1, move |h, q, p| {
            p[0] -= h * q[0].sin();
            p[0] *= 1.0 - h * friction;
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.3], vec![0.5], 1.0).unwrap();
        Diagnostic::default().run(&map, &circle).unwrap()
    }

    /// Sentences without the breaks of lines.
    fn unfolded(text: &str) -> String {
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn the_summary_does_not_repeat_the_headline() {
        let verdict = diagnosed(0.01).verdict;
        let law = " in proportion to h";
        assert!(verdict.headline().ends_with(law), "{}", verdict.headline());
        assert!(verdict.summary().contains(law));
        let summary = summary(&verdict);
        assert!(
            !summary.contains(law) && summary.ends_with("at h = 0.5."),
            "{summary}"
        );
    }

    #[test]
    fn a_diagnosis_fits_one_screen() {
        for (friction, words) in [
            (
                0.0,
                [
                    "8 more, none above its uncertainty",
                    "Strictness The largest step",
                ],
            ),
            (
                0.01,
                [
                    "⋮ 0.000977",
                    "Power of h The leading power of h in the change of your loop",
                ],
            ),
        ] {
            let diagnosis = diagnosed(friction);
            let shown = DisplayOptions {
                width: Some(80),
                all: false,
            };
            let text = diagnosis_text("step", &diagnosis, shown);
            assert!(text.lines().count() <= 36, "{text}");
            assert!(
                text.lines().all(|line| line.chars().count() <= 80),
                "{text}"
            );
            for word in words {
                assert!(unfolded(&text).contains(word), "{text}");
            }
            let all = diagnosis_text("step", &diagnosis, DisplayOptions { all: true, ..shown });
            assert!(all.contains("0.000977") && !all.contains('⋮'), "{all}");
        }
    }
}
