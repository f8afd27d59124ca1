//! The two-form that a map preserves instead of the canonical one.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::{Cause, CauseKind, Clues};
use crate::evidence::{DigitsOfMatrix, FormEntry, FormOnLoop, PreservedForm, uncertain_part};
use crate::signal::{CERTAIN, SIGNIFICANT};
use crate::text::{one_digit, significant, size, two_digits};
use crate::verdict::advice::Advice;

/// Entries of a form that are written out.
const MAX_ENTRIES: usize = 12;

/// Degrees of freedom up to which a form is written as a matrix, and the momenta of a field are written out.
const MAX_DOF_OF_MATRIX: usize = 3;

/// Degrees of freedom from which a linear step may be one of fields on a grid.
const MIN_DOF_OF_FIELDS: usize = 3;

impl Clues<'_> {
    /// The momenta are not canonical: the map preserves another form, on loops as well.
    pub(super) fn other_form(&self) -> Option<Cause> {
        let form = self.evidence.preserved_form.as_ref()?;
        let bound = form.bound_on_loops()?;
        if let Some(order) = self.order.filter(|order| *order >= 2.0) {
            return Some(self.form_of_method(form, bound, order));
        }
        let kind = form.kind();
        let (meaning, setting, remedy) = match kind {
            CauseKind::VelocitiesForMomenta => (
                "p are velocities or momenta in other units, or a force between two coordinates has a wrong factor",
                form.weights_setting(),
                "If these weights are your masses or conversions of units, pass them with all their digits, or give the momenta weight × p",
            ),
            CauseKind::SignOfAPair => (
                "a pair (q, p) has the other sign, as if q and p are interchanged, or a force between two coordinates has a wrong sign",
                form.weights_setting(),
                "If a coordinate has the other sign on purpose, pass these weights, with radii that differ (equal areas cancel), or \
                 change the sign of one coordinate of each pair with -1",
            ),
            CauseKind::PairsPermuted => (
                "q and p are not in the same order",
                form.pairs_setting(),
                "Give p in the order of q: as many p[i] as q[i] names here",
            ),
            CauseKind::KineticMomenta if form.varies() => (
                "p may be kinetic momenta in a magnetic field that varies with q",
                form.field_setting(),
                "Give the canonical momenta p = m v + e A(q), here",
            ),
            CauseKind::KineticMomenta => (
                "p may be kinetic momenta in a uniform magnetic field, or velocities in a rotating frame",
                form.field_setting(),
                "Give the canonical momenta, or this form for the step of z = (q, p)",
            ),
            CauseKind::Fields => (
                "the step is linear and couples each q with several p, as Yee's scheme does for the fields (E, B): B is not conjugate to E",
                form.form_setting(),
                "Give the vector potential A with B = curl A, which is conjugate to E, instead of B, or this form for the step of z = (q, p)",
            ),
            _ => (
                "q and p are not conjugate one by one, as for positions in other axes than momenta",
                form.form_setting(),
                "Give the momenta that are conjugate to q, or this form for the step of z = (q, p)",
            ),
        };
        let step = form
            .step_size
            .map_or("The step".to_owned(), |h| format!("A step of {}", size(h)));
        let mut text = format!(
            "{step} conserves the areas of another form than Σ dq∧dp: {}. They change by at most {} on {}, and the Jacobian agrees at {} \
             states. So {meaning}.",
            form.sum(),
            one_digit(bound),
            form.on_loops(),
            form.states
        );
        if form.groups > 1 {
            text += &format!(
                " {} groups of coordinates are not coupled: the factor of each part of the form is free.",
                form.groups
            );
        }
        // Masses, signs and pairs are the same in steps of all sizes; what a method makes of a field is not.
        let is_of_step = !matches!(
            kind,
            CauseKind::VelocitiesForMomenta | CauseKind::SignOfAPair | CauseKind::PairsPermuted
        );
        let of_step = form.step_size.filter(|_| is_of_step);
        let only = of_step.map_or(String::new(), |h| {
            format!(
                " Test it with steps of {} alone: other step sizes may preserve another form.",
                size(h)
            )
        });
        // If one coordinate feels a force with a wrong factor, other units of its momentum make it a gradient.
        let otherwise = match kind {
            CauseKind::VelocitiesForMomenta | CauseKind::SignOfAPair => {
                " Otherwise test the force with `check_force`: a coupling with a wrong sign or factor looks the same."
            }
            CauseKind::OtherForm => {
                " Otherwise test the force with `check_force`: a pair force without its reaction looks the same."
            }
            CauseKind::KineticMomenta if form.step_size.is_some() => {
                " A field does not depend on h. If a smaller step halves these numbers with h, there is no field, and two kicks or drifts of \
                 the step differ. Then test a kick alone, and look for a mass or a factor 1/2 that one of them forgets."
            }
            _ => "",
        };
        Some(Cause {
            setting: Some(setting.clone()),
            digits: Some((-bound.max(uncertain_part(&form.entries)).log10() * 10.0).floor() / 10.0),
            ..Cause::new(kind, text, format!("{remedy}: {setting}.{otherwise}{only}"))
        })
    }

    /// A transfer matrix was written with few digits. The matrix of a step depends on its size, and is computed.
    pub(super) fn rounded_matrix(&self) -> Option<Cause> {
        // Rounding leaves no other form that is preserved.
        let form = (self.evidence.preserved_form.as_ref())
            .filter(|of| of.step_size.is_none() && of.exists != Some(true))?;
        let digits = match form.digits_of_matrix? {
            DigitsOfMatrix::Decimals(k) => format!("{k} digits after the point"),
            DigitsOfMatrix::Significant(k) => format!("{k} significant digits"),
        };
        let text = format!(
            "The map is linear, and its matrix has at most {digits}. Rounding a symplectic matrix to them can cause a defect of this size."
        );
        let remedy = "Give the matrix all its digits, or make it symplectic again before it is applied many times. If the matrix was \
                      not rounded, look for friction.";
        Some(Cause::new(CauseKind::RoundedMatrix, text, remedy))
    }

    /// Wrong variables make a defect of order h. If it falls faster, q and p are canonical, and the form is that of the method.
    fn form_of_method(&self, form: &PreservedForm, bound: f64, order: f64) -> Cause {
        let step = form
            .step_size
            .map_or(String::new(), |h| format!(" of {}", size(h)));
        let text = format!(
            "q and p are canonical, as the change is proportional to h^{order}, and the method is not symplectic. A step{step} conserves \
             the areas of a form that depends on h: {}. They change by at most {} on {}.",
            form.sum(),
            one_digit(bound),
            form.on_loops()
        );
        Cause::new(CauseKind::OtherForm, text, self.remedy())
    }

    /// What defects of this order have for a cause, if no advice is better.
    pub(super) fn remedy(&self) -> String {
        let is_cause = |advice: &&Advice| !advice.is_general() && !advice.is_of_order();
        match self.advice.iter().find(is_cause) {
            Some(advice) => advice.to_string(),
            None => Advice::on_order(self.slope(), self.properties).to_string(),
        }
    }

    /// No constant form is preserved.
    pub(super) fn no_form(&self) -> Option<Cause> {
        let form = self.evidence.preserved_form.as_ref()?;
        form.exists.filter(|exists| !exists)?;
        let (what, family) = match form.all_constant {
            true if form.with_fields => (
                "masses, signs, pairs (q[i], p[j]) or magnetic field of at most degree 2",
                "two-form with such a field",
            ),
            true => (
                "masses, signs, pairs (q[i], p[j]) or uniform magnetic field",
                "constant two-form",
            ),
            false => ("masses or signs", "form Σ c dq∧dp with constant weights c"),
        };
        let nearest = match form.change {
            Some(change) => format!(
                "the {family} that is conserved best changes by {} of its largest entry",
                two_digits(change)
            ),
            None => "the forms Σ c dq∧dp that do not change have a weight c of 0, as if a coordinate acts on others that do not act on it"
                .to_owned(),
        };
        let text = format!(
            "Other variables do not help: no {what} make the step symplectic. At {} states, {nearest}.",
            form.states
        );
        Some(Cause::new(CauseKind::NoForm, text, self.remedy()))
    }
}

impl PreservedForm {
    /// The largest change that integrals of the form may have, if loops confirm that it is preserved, and that the canonical form
    /// is not.
    fn bound_on_loops(&self) -> Option<f64> {
        let relative = self.entries.iter().map(FormEntry::relative_error);
        let of_entries = relative.fold(0.0, f64::max);
        let is_preserved = |of: &FormOnLoop| {
            let [change, uncertainty] = of.preserved;
            change.abs() <= of_entries.max(SIGNIFICANT * uncertainty)
        };
        if self.exists != Some(true) || !self.loops.iter().all(is_preserved) {
            return None;
        }
        let bound = self.loops.iter().map(FormOnLoop::bound).reduce(f64::max)?;
        let changes = self.loops.iter().map(|of| of.canonical[0].abs());
        (changes.fold(0.0, f64::max) > CERTAIN * bound).then_some(bound)
    }

    /// Whether it is not constant.
    fn varies(&self) -> bool {
        self.entries.iter().any(|entry| entry.powers != [0; 3])
    }

    /// Whether an entry is that of a position and a momentum.
    fn is_mixed(&self, entry: &FormEntry) -> bool {
        let [a, b] = entry.coordinates;
        a < self.dof && b >= self.dof
    }

    /// The momentum that each position has an entry with, if it is one for each, and the entry.
    fn pairs(&self) -> Option<Vec<(usize, f64)>> {
        let mut pairs = vec![None; self.dof];
        for entry in self.entries.iter().filter(|entry| self.is_mixed(entry)) {
            let [q, p] = entry.coordinates;
            if pairs[q].replace((p - self.dof, entry.value)).is_some() {
                return None;
            }
        }
        let pairs: Vec<(usize, f64)> = pairs.into_iter().collect::<Option<_>>()?;
        let mut of_p: Vec<usize> = pairs.iter().map(|pair| pair.0).collect();
        of_p.sort_unstable();
        of_p.dedup();
        (of_p.len() == self.dof).then_some(pairs)
    }

    fn kind(&self) -> CauseKind {
        let Some(pairs) = self.pairs() else {
            return match self.is_linear && self.dof >= MIN_DOF_OF_FIELDS {
                true => CauseKind::Fields,
                false => CauseKind::OtherForm,
            };
        };
        let is_in_order = pairs.iter().enumerate().all(|(q, (p, _))| q == *p);
        let is_of_pairs = self.entries.iter().all(|entry| self.is_mixed(entry));
        let is_of_positions = |entry: &FormEntry| entry.coordinates[1] < self.dof;
        match (is_in_order, is_of_pairs) {
            (true, true) if pairs.iter().all(|pair| pair.1.abs() == 1.0) => CauseKind::SignOfAPair,
            (true, true) => CauseKind::VelocitiesForMomenta,
            (false, true) => CauseKind::PairsPermuted,
            (true, false) if self.entries.iter().any(is_of_positions) => CauseKind::KineticMomenta,
            _ => CauseKind::OtherForm,
        }
    }

    /// Ω_ij(q) of positions: the powers of q in each, with their factors.
    fn fields(&self) -> BTreeMap<[usize; 2], BTreeMap<[u8; 3], f64>> {
        let mut fields: BTreeMap<_, BTreeMap<_, f64>> = BTreeMap::new();
        let of_positions = self
            .entries
            .iter()
            .filter(|entry| entry.coordinates[1] < self.dof);
        for entry in of_positions {
            let [a, b] = entry.coordinates;
            // An entry has the derivatives of this product of positions.
            let mut product = entry.powers;
            product[a] += 1;
            for i in (0..product.len()).filter(|&i| product[i] > 0 && i != b) {
                let mut powers = product;
                powers[i] -= 1;
                let value = entry.value * f64::from(product[i]) / f64::from(product[a]);
                let (pair, value) = match i < b {
                    true => ([i, b], value),
                    false => ([b, i], -value),
                };
                *fields.entry(pair).or_default().entry(powers).or_default() += value;
            }
        }
        fields
    }

    fn weights_setting(&self) -> String {
        let weights = self.pairs().unwrap_or_default();
        let texts: Vec<String> = weights.iter().map(|pair| number(pair.1)).collect();
        format!("weight = [{}]", texts.join(", "))
    }

    /// The order of p, with weights if there are any.
    fn pairs_setting(&self) -> String {
        let pairs = self.pairs().unwrap_or_default();
        let order: Vec<String> = pairs.iter().map(|pair| pair.0.to_string()).collect();
        let order = format!("p = p[:, [{}]]", order.join(", "));
        match pairs.iter().all(|pair| pair.1 == 1.0) {
            true => order,
            false => format!("{order}, {}", self.weights_setting()),
        }
    }

    /// The canonical momenta of kinetic ones, if momenta have no entries with each other.
    fn field_setting(&self) -> String {
        let of_momenta = |entry: &FormEntry| entry.coordinates[0] >= self.dof;
        // Fields that vary are those of few positions.
        if self.dof > MAX_DOF_OF_MATRIX || self.entries.iter().any(of_momenta) {
            return self.form_setting();
        }
        let pairs = self.pairs().unwrap_or_default();
        let momentum = |i: usize| {
            let weight = pairs[i].1;
            let mut text = match weight == 1.0 {
                true => format!("p[{i}]"),
                false => format!("{} p[{i}]", number(weight)),
            };
            for entry in self.entries.iter().filter(|of| !self.is_mixed(of)) {
                let [a, b] = entry.coordinates;
                let mut powers = entry.powers;
                // The potential of a field that varies is a part of one momentum; half of Ω_ab dq_a∧dq_b belongs to each of the two.
                let (value, product) = match (self.varies(), a == i, b == i) {
                    (false, true, _) => (0.5 * entry.value, format!("q[{b}]")),
                    (false, _, true) => (-0.5 * entry.value, format!("q[{a}]")),
                    (true, _, true) => {
                        powers[a] += 1;
                        let value = -entry.value / f64::from(powers[a]);
                        (value, product(powers, |i| format!("q[{i}]")))
                    }
                    _ => continue,
                };
                let sign = if value < 0.0 { '−' } else { '+' };
                text += &format!(" {sign} {} {product}", number(value.abs()));
            }
            text
        };
        let momenta: Vec<String> = (0..self.dof).map(momentum).collect();
        format!("p = ({})", momenta.join(", "))
    }

    /// Half of z·Ω is the one-form whose derivative is the form.
    fn form_setting(&self) -> String {
        if self.dof > MAX_DOF_OF_MATRIX {
            return "form = lambda z: z @ Ω / 2 with Ω_ab of `evidence.preserved_form`".to_owned();
        }
        let entry = |a: usize, b: usize| {
            let value = |a: usize, b: usize| {
                let mut entries = self.entries.iter();
                entries
                    .find(|entry| entry.coordinates == [a, b])
                    .map(|entry| entry.value)
            };
            value(a, b)
                .or_else(|| value(b, a).map(|x| -x))
                .unwrap_or(0.0)
        };
        let row = |a: usize| {
            let entries: Vec<String> = (0..2 * self.dof).map(|b| number(entry(a, b))).collect();
            format!("[{}]", entries.join(", "))
        };
        let rows: Vec<String> = (0..2 * self.dof).map(row).collect();
        format!("form = lambda z: z @ Ω / 2 with Ω = [{}]", rows.join(", "))
    }

    /// The form as a sum, its largest entries if there are many: `dq0∧dp0 + 3 dq1∧dp1`.
    fn sum(&self) -> String {
        let is_shown = |entry: &&FormEntry| !self.varies() || self.is_mixed(entry);
        let mut largest: Vec<&FormEntry> = self.entries.iter().filter(is_shown).collect();
        let all = largest.len();
        if largest.len() > MAX_ENTRIES {
            largest.sort_by(|a, b| b.value.abs().total_cmp(&a.value.abs()));
            largest.truncate(MAX_ENTRIES);
        }
        largest.sort_by_key(|entry| (!self.is_mixed(entry), entry.coordinates));
        let name = |c: usize| match c < self.dof {
            true => format!("dq{c}"),
            false => format!("dp{}", c - self.dof),
        };
        let mut text = String::new();
        for entry in &largest {
            let sign = match (entry.value < 0.0, text.is_empty()) {
                (true, true) => "−",
                (true, false) => " − ",
                (false, true) => "",
                (false, false) => " + ",
            };
            let factor = match entry.value.abs() {
                1.0 => String::new(),
                size => format!("{} ", significant(size)),
            };
            let [a, b] = entry.coordinates.map(name);
            text += &format!("{sign}{factor}{a}∧{b}");
        }
        if self.varies() {
            for ([a, b], field) in self.fields() {
                text += &format!(" + ({}) dq{a}∧dq{b}", polynomial(&field));
            }
        }
        match all - largest.len() {
            0 => text,
            more => format!("{text} + {more} smaller terms"),
        }
    }

    fn on_loops(&self) -> &'static str {
        match (self.loops.len(), self.loops.first().map(|of| of.loop_index)) {
            (1, Some(0)) => "your loop",
            (1, _) => "a random loop",
            _ => "your loop and a random one",
        }
    }
}

/// `0.7 + 0.3 q0 − 0.2 q0² q1`.
fn polynomial(terms: &BTreeMap<[u8; 3], f64>) -> String {
    let mut text = String::new();
    let mut sorted: Vec<_> = terms.iter().filter(|(_, value)| **value != 0.0).collect();
    // Lower degrees first, and q0 before q1.
    sorted.sort_by_key(|(powers, _)| (powers.iter().sum::<u8>(), Reverse(**powers)));
    for (powers, value) in sorted {
        let sign = match (*value < 0.0, text.is_empty()) {
            (true, true) => "−",
            (true, false) => " − ",
            (false, true) => "",
            (false, false) => " + ",
        };
        text += &format!("{sign}{}", significant(value.abs()));
        if *powers != [0; 3] {
            text += &format!(" {}", product(*powers, |i| format!("q{i}")));
        }
    }
    text
}

/// `q0² q1`.
fn product(powers: [u8; 3], name: impl Fn(usize) -> String) -> String {
    let factor = |(i, power): (usize, &u8)| match power {
        0 => None,
        1 => Some(name(i)),
        2 => Some(format!("{}²", name(i))),
        _ => Some(format!("{}³", name(i))),
    };
    let factors: Vec<String> = powers.iter().enumerate().filter_map(factor).collect();
    factors.join(" ")
}

/// All digits that a number has, and an exponent if it needs one.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        1e-4..1e6 => format!("{value}"),
        _ => format!("{value:e}"),
    }
}
