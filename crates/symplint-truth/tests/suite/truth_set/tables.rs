//! What came of all members, as markdown.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::book::{grouped, short};
use crate::truth_set::follow::Followed;
use crate::truth_set::outcome::{Order, Outcome};
use crate::truth_set::ratios::{Ratios, quantile};

/// What came of one member.
pub struct Line {
    pub family: &'static str,
    pub index: usize,
    pub label: String,
    pub outcome: Outcome,
    pub followed: Option<Followed>,
    pub order: Option<Order>,
    /// Breaks: true ones, and those found, if all are said to be known.
    pub breaks: Option<(usize, Option<usize>)>,
    pub ratios: Vec<(String, f64)>,
    /// The cause of a failure, or its first advice; `Some("")` if there is neither.
    pub cause: Option<String>,
    pub seconds: f64,
}

impl Line {
    /// Whether the verdict, or that to which its advice leads, or the order is wrong.
    pub fn is_wrong(&self) -> bool {
        matches!(self.outcome, Outcome::Wrong(_))
            || matches!(self.followed, Some(Followed::Wrong(_)))
            || matches!(self.order, Some(Order::Wrong(_)))
            || self.cause.as_deref() == Some("")
    }
}

/// The confusion matrix by family.
pub fn confusion(lines: &[Line]) -> String {
    let mut text =
        "| family | members | right | undecided | of these, right after advice | right with more digits or a tighter solver | \
                    still undecided after advice | wrong after advice | wrong |\n"
            .to_string();
    text += "|---|---|---|---|---|---|---|---|---|\n";
    let mut names: Vec<&str> = lines.iter().map(|line| line.family).collect();
    names.dedup();
    names.push("all");
    for name in names {
        let of: Vec<&Line> = (lines.iter())
            .filter(|line| name == "all" || line.family == name)
            .collect();
        let count = |is: &dyn Fn(&Line) -> bool| of.iter().filter(|line| is(line)).count();
        let followed =
            |is: fn(&Followed) -> bool| count(&|line| line.followed.as_ref().is_some_and(is));
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} | {} | {} | {} |",
            grouped(of.len()),
            grouped(count(&|line| line.outcome == Outcome::Right)),
            count(&|line| line.outcome == Outcome::Undecided),
            followed(|f| *f == Followed::Decides),
            followed(|f| *f == Followed::InFullPrecision),
            followed(|f| matches!(f, Followed::Open(_))),
            followed(|f| matches!(f, Followed::Wrong(_))),
            count(&|line| matches!(line.outcome, Outcome::Wrong(_))),
        )
        .unwrap();
    }
    text
}

/// How many failures have a cause or advice.
pub fn advised(lines: &[Line]) -> String {
    let failures = || lines.iter().filter_map(|line| line.cause.as_deref());
    let stated = failures().filter(|cause| !cause.is_empty() && !cause.starts_with("none;"));
    format!(
        "Of the {} verdicts that report a failure, {} state a cause. The others have advice, which names the likeliest causes first.\n",
        grouped(failures().count()),
        grouped(stated.count())
    )
}

/// Causes of failures by family, with the advice if no cause is stated.
pub fn causes(lines: &[Line]) -> String {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for line in lines {
        if let Some(cause) = &line.cause {
            *counts.entry((line.family, cause)).or_default() += 1;
        }
    }
    let mut text = "| family | cause of a failure | members |\n|---|---|---|\n".to_string();
    for ((family, cause), count) in counts {
        writeln!(text, "| {family} | {cause} | {count} |").unwrap();
    }
    text
}

/// Quantiles of true error over stated error.
pub fn quantiles(lines: &[Line]) -> String {
    let mut all = Ratios::new();
    for (name, ratio) in lines.iter().flat_map(|line| &line.ratios) {
        all.entry(name.clone()).or_default().push(*ratio);
        if let Some(rule) = rule_of(name) {
            let of_rule = format!("all integrals, {rule}");
            all.entry(of_rule).or_default().push(*ratio);
        }
    }
    let mut text =
        "| true error / stated error | numbers | 50% | 90% | 99% | 99.9% | largest | within |\n\
                    |---|---|---|---|---|---|---|---|\n"
            .to_string();
    for (name, mut ratios) in all {
        ratios.sort_by(f64::total_cmp);
        let within = ratios.iter().filter(|ratio| **ratio <= 1.0).count();
        let at = |part| quantile(&ratios, part);
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} | {} | {:.2}% |",
            grouped(ratios.len()),
            short(at(0.5)),
            short(at(0.9)),
            short(at(0.99)),
            short(at(0.999)),
            short(at(1.0)),
            100.0 * within as f64 / ratios.len() as f64
        )
        .unwrap();
    }
    text
}

/// The rule of an integral, if the ratio is of one.
fn rule_of(name: &str) -> Option<&str> {
    let (what, rest) = name.split_once(", ")?;
    let is_integral = what.starts_with("change") || what.starts_with("integral");
    is_integral.then(|| rest.split(',').next().expect("a split has a first part"))
}

/// Orders and numbers of breaks.
pub fn counts(lines: &[Line]) -> String {
    let order = |is: fn(&Order) -> bool| {
        lines
            .iter()
            .filter(|line| line.order.as_ref().is_some_and(is))
            .count()
    };
    let breaks = |family: &str, is: fn(usize, Option<usize>) -> bool| {
        (lines.iter().filter(|line| line.family == family))
            .filter(|line| line.breaks.is_some_and(|(known, found)| is(known, found)))
            .count()
    };
    let mut text = "| statement | right | open | wrong |\n|---|---|---|---|\n".to_string();
    let (right, open) = (order(|o| *o == Order::Right), order(|o| *o == Order::Open));
    let wrong = order(|o| matches!(o, Order::Wrong(_)));
    writeln!(text, "| order | {right} | {open} | {wrong} |").unwrap();
    for family in ["breaks", "tolerance"] {
        let (right, open) = (
            breaks(family, |a, b| Some(a) <= b),
            breaks(family, |_, b| b.is_none()),
        );
        let wrong = breaks(family, |a, b| b.is_some_and(|b| a > b));
        writeln!(
            text,
            "| number of breaks, {family} | {right} | {open} | {wrong} |"
        )
        .unwrap();
    }
    text
}

/// Every member that is not right, or states a wrong order or number of breaks, or an error that is far too small.
pub fn faults(lines: &[Line]) -> String {
    let mut text = String::new();
    for line in lines {
        let mut say = |what: String| {
            writeln!(
                text,
                "{} {}: {}: {what}",
                line.family, line.index, line.label
            )
            .unwrap();
        };
        match (&line.outcome, &line.followed) {
            (Outcome::Wrong(why), _) => say(format!("WRONG {why}")),
            (Outcome::Undecided, Some(Followed::Wrong(why))) => say(format!("LED WRONG {why}")),
            (Outcome::Undecided, Some(Followed::Open(why))) => say(format!("OPEN {why}")),
            _ => {}
        }
        if let Some(Order::Wrong(found)) = line.order {
            say(format!("ORDER {found}"));
        }
        if let Some((known, Some(found))) =
            line.breaks.filter(|(known, found)| Some(*known) > *found)
        {
            say(format!("BREAKS {found} found of {known}"));
        }
        let worst = line.ratios.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((name, ratio)) = worst.filter(|(_, ratio)| *ratio > 1.0) {
            say(format!("ERROR BAR {name}: {ratio:.2}"));
        }
    }
    text
}
