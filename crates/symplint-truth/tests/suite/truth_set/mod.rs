//! The truth set: families of random maps whose right answer is known, and what the diagnosis says of them.
//!
//! A member is made from its family and its number alone. The normal tests run every 20th;
//! `cargo test --release -p symplint-truth truth_set:: -- --ignored` runs all of them and writes the
//! tables of docs/truth.md to `target/tmp/truth`; the variable `TRUTH_SET_FAMILIES=units,sizes` chooses some of them. `TRUTH_SET_MEMBER=steep:23` and the test
//! `one_member` print what is said of one.

mod advice;
mod batch_rounding;
mod batches;
mod breaks;
mod budgets;
mod coarse;
mod constraint;
mod control;
mod follow;
mod hidden;
mod kept_evidence;
mod laws;
mod leaves;
mod links;
mod member;
mod memory;
mod methods;
mod networks;
mod noise;
mod orders;
mod outcome;
mod pairs;
mod periodic;
mod precision;
mod random;
mod ratios;
mod rounding;
mod rows;
mod rules;
mod sizes;
mod small;
mod stated_periods;
mod steep;
mod strips;
mod systems;
mod tables;
mod thin;
mod tolerance;
mod units;

use std::time::Instant;

use rayon::prelude::*;

use crate::book;
use follow::{follow, follow_error};
use member::{Expected, Member};
use outcome::{Outcome, diagnose, order, outcome, outcome_of_error};
use symplint::{Error, Verdict, VerdictKind};
use symplint_truth::kept;
use tables::Line;

/// Members of one kind.
struct Family {
    name: &'static str,
    count: usize,
    member: fn(usize) -> Member,
}

macro_rules! families {
    ($($name:ident),*) => {
        &[$(Family {
            name: stringify!($name),
            count: $name::COUNT,
            member: $name::member,
        }),*]
    };
}

const FAMILIES: &[Family] = families![
    units,
    precision,
    coarse,
    tolerance,
    constraint,
    sizes,
    orders,
    small,
    breaks,
    rules,
    periodic,
    thin,
    stated_periods,
    rows,
    pairs,
    leaves,
    strips,
    steep,
    laws,
    hidden,
    advice,
    batch_rounding,
    noise,
    memory
];

/// One in this number of members runs in the normal tests.
const PART: usize = 20;

fn line(family: &Family, index: usize) -> Line {
    let started = Instant::now();
    let member = (family.member)(index);
    let found = diagnose(&member.subject);
    let mut line = Line {
        family: family.name,
        index,
        label: member.label.clone(),
        outcome: Outcome::Undecided,
        followed: None,
        order: None,
        breaks: None,
        ratios: Vec::new(),
        cause: None,
        seconds: 0.0,
    };
    match &found {
        Ok(found) => {
            let name = format!("{} {index}", family.name);
            kept::keep(&name, &found.evidence, &found.verdict);
            line.outcome = outcome(&member, found);
            if line.outcome == Outcome::Undecided {
                line.followed = Some(follow(&member, found));
            }
            line.order = order(&member.truth, found);
            let known = member.truth.breaks.as_ref().map(Vec::len);
            let counted = ratios::found_breaks(&member.truth, found)
                .filter(|_| !ratios::may_be_more(found))
                .map(|breaks| breaks.iter().flatten().count());
            line.breaks = known.map(|known| (known, counted));
            line.ratios = ratios::ratios(&member, found);
            line.cause = cause(&found.verdict);
        }
        Err(Error::NotAPeriod { .. }) if matches!(member.truth.expected, Expected::WrongPeriod) => {
            line.outcome = Outcome::Right;
        }
        Err(error @ Error::NotAPeriod { .. }) => line.outcome = Outcome::Wrong(error.to_string()),
        Err(error) => {
            line.outcome = outcome_of_error(&member, error);
            if line.outcome == Outcome::Undecided {
                line.followed = Some(follow_error(&member, error));
            }
        }
    }
    line.seconds = started.elapsed().as_secs_f64();
    line
}

/// The cause of a failure, or what its first advice begins with.
fn cause(verdict: &Verdict) -> Option<String> {
    let failed = matches!(
        verdict.kind,
        VerdictKind::NotSymplectic | VerdictKind::BrokenLoops
    );
    failed.then(|| match (&verdict.cause, verdict.advice().first()) {
        (Some(cause), _) => format!("{:?}", cause.kind),
        (None, Some(advice)) => {
            let words = advice.split_whitespace().take(5);
            format!("none; {} …", words.collect::<Vec<_>>().join(" "))
        }
        (None, None) => String::new(),
    })
}

/// Whether a small budget can miss what a member of this family does.
fn may_hide(family: &str) -> bool {
    matches!(family, "tolerance" | "strips" | "memory")
}

/// Every `part`-th member of the families named.
fn run(part: usize, named: impl Fn(&str) -> bool) -> Vec<Line> {
    let all: Vec<(&Family, usize)> = (FAMILIES.iter().filter(|family| named(family.name)))
        .flat_map(|family| {
            (0..family.count)
                .step_by(part)
                .map(move |index| (family, index))
        })
        .collect();
    all.par_iter()
        .map(|(family, index)| line(family, *index))
        .collect()
}

fn print(lines: &[Line]) {
    println!("{}", tables::confusion(lines));
    println!("{}", tables::counts(lines));
    println!("{}", tables::causes(lines));
    println!("{}", tables::quantiles(lines));
    println!("{}", tables::faults(lines));
    let seconds: f64 = lines.iter().map(|line| line.seconds).sum();
    println!("{} members, {seconds:.0} s", lines.len());
}

#[test]
fn the_set_is_large() {
    let count: usize = FAMILIES.iter().map(|family| family.count).sum();
    assert!(count >= 2000, "{count}");
}

#[test]
fn every_twentieth_member() {
    let lines = run(PART, |_| true);
    print(&lines);
    let wrong: Vec<&Line> = lines.iter().filter(|line| line.is_wrong()).collect();
    assert!(wrong.is_empty(), "{}", tables::faults(&lines));
}

/// Other members than those that run above. Jumps of solvers that few samples do not show are left out: docs/truth.md has
/// their number. So are strips that few samples do not meet, and dependences on earlier calls and on batches that few
/// evaluations do not meet.
#[test]
fn no_budget_makes_a_wrong_verdict() {
    let found = budgets::run(PART, PART / 2, |family| !may_hide(family));
    println!("{}", budgets::table(&found, &[]));
    assert!(
        budgets::wrong(&found).is_empty(),
        "{:#?}",
        budgets::wrong(&found)
    );
}

#[test]
#[ignore = "minutes: writes the tables of docs/truth.md"]
fn all_members() {
    let chosen = std::env::var("TRUTH_SET_FAMILIES").ok();
    let is_chosen = |name: &str| {
        let chosen = chosen.as_deref();
        chosen.is_none_or(|chosen| chosen.split(',').any(|family| family == name))
    };
    let mut lines = Vec::new();
    for family in FAMILIES.iter().filter(|family| is_chosen(family.name)) {
        let started = Instant::now();
        lines.extend(run(1, |name| name == family.name));
        eprintln!("{}: {:.0} s", family.name, started.elapsed().as_secs_f64());
    }
    let hard = budgets::run(1, 0, |family| is_chosen(family) && may_hide(family));
    let others = budgets::run(1, 0, |family| is_chosen(family) && !may_hide(family));
    if chosen.is_some() {
        print(&lines);
        println!("{}", budgets::table(&others, &hard));
        return;
    }
    println!("{}\n{}", tables::causes(&lines), tables::faults(&lines));
    book::publish("verdicts", &tables::confusion(&lines));
    book::publish("causes", &tables::advised(&lines));
    book::publish("statements", &tables::counts(&lines));
    book::publish("errors", &tables::quantiles(&lines));
    println!("{:#?}", budgets::wrong(&hard));
    book::publish("budgets", &budgets::table(&others, &hard));
    book::publish("summary", &summary(&lines, &[hard, others].concat()));
}

/// The numbers of the README.
fn summary(lines: &[Line], small_budgets: &[budgets::Found]) -> String {
    let undecided = lines
        .iter()
        .filter(|line| line.outcome == Outcome::Undecided);
    let wrong = |count| match count {
        0 => "no verdict is".to_owned(),
        1 => "1 is".to_owned(),
        _ => format!("{count} are"),
    };
    format!(
        "On {} random maps with a known answer and the automatic budget, {} [wrong](PAGEtruth.md), and {} are undecided. On {}\n\
         of them with 20,000 evaluations, the default in Python, {} [wrong](PAGEtruth.md#small-budgets).\n",
        book::grouped(lines.len()),
        wrong(lines.iter().filter(|line| line.is_wrong()).count()),
        undecided.count(),
        book::grouped(
            small_budgets
                .iter()
                .filter(|found| found.budget == 20_000)
                .count()
        ),
        wrong(budgets::wrong_of(small_budgets, 20_000)),
    )
}

#[test]
#[ignore = "prints the verdict of one member, TRUTH_SET_MEMBER=steep:23"]
fn one_member() {
    let member = std::env::var("TRUTH_SET_MEMBER").expect("TRUTH_SET_MEMBER");
    let (name, index) = member.split_once(':').expect("a family:number");
    let index = index.parse().expect("a number");
    let mut families = FAMILIES.iter();
    let family = families.find(|family| family.name == name).expect("family");
    let member = (family.member)(index);
    println!("{}", member.label);
    match diagnose(&member.subject) {
        Ok(found) => println!("{}", found.verdict),
        Err(error) => println!("{error}"),
    }
    print(&[line(family, index)]);
}
