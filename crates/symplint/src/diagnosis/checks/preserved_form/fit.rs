//! The closed two-form that Jacobians preserve: a constant one, or one with a field that is a polynomial in q.

use nalgebra::DMatrix;

use super::limits::{
    MAX_DEGREE, MAX_ZERO_ENTRY, MIN_ENTRY_NEAR_ONE, MIN_SINGULAR_VALUE, MIN_WIDTH, UNIT_ROUNDS,
};
use super::null_space::{Equations, NullSpace, Solutions};
use crate::evidence::monomial;
use crate::jacobian::TangentImages;
use crate::signal::{GOLDEN_RATIO, NEGLIGIBLE, SIGNIFICANT};

/// dz_a∧dz_b, or d(z_a q^m dz_b)/(1 + m_a) with powers m of the first three coordinates, which is closed, too.
#[derive(Clone, Copy)]
pub(super) struct Term {
    pub pair: (usize, usize),
    pub powers: [u8; 3],
}

/// A term of a form, in units of the loop.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub term: Term,
    pub value: f64,
    pub error: f64,
    /// The group of coordinates: the factor of its entries is free.
    pub group: usize,
}

/// The answer.
pub(super) enum FormFit {
    Preserved(Vec<Entry>),
    /// The form that is nearest to a preserved one changes by this part of its largest entry.
    None {
        change: f64,
    },
    /// A weight is 0 in all preserved forms Σ c dq∧dp, and no other form was found: some coordinates do not act on others.
    Degenerate,
    Open,
}

/// The form that `images` at several states have in common: of all constant ones, if they are those of all unit vectors; else of
/// weights and signs. One of weights and signs is preferred.
pub(super) fn preserved(images: &[TangentImages], dof: usize, all_constant: bool) -> FormFit {
    let mut entries: Vec<Entry> = Vec::new();
    let (mut is_open, mut is_degenerate) = (false, false);
    let mut add = |fit: FormFit| match fit {
        FormFit::Preserved(found) => {
            let first = entries.iter().map(|entry| entry.group + 1).max();
            entries.extend(found.into_iter().map(|entry| Entry {
                group: first.unwrap_or(0) + entry.group,
                ..entry
            }));
            None
        }
        FormFit::Open => {
            is_open = true;
            None
        }
        FormFit::Degenerate => {
            is_degenerate = true;
            None
        }
        none @ FormFit::None { .. } => Some(none),
    };
    let (pairs_of_all, coordinates) = match all_constant {
        true => (parts(images, dof, true), parts(images, dof, false)),
        false => (vec![(0..2 * dof).collect()], Vec::new()),
    };
    for part in pairs_of_all {
        match weights(images, dof, &part) {
            fit @ (FormFit::None { .. } | FormFit::Degenerate) if all_constant => {
                let has_degenerate = matches!(fit, FormFit::Degenerate);
                let within = |of: &&Vec<usize>| of.iter().all(|c| part.contains(c));
                let smaller: Vec<&Vec<usize>> = coordinates.iter().filter(within).collect();
                if dof == 1 {
                    return fit;
                }
                for of in smaller {
                    let fit = match general(images, dof, of) {
                        FormFit::Open if has_degenerate => FormFit::Degenerate,
                        fit => fit,
                    };
                    if let Some(none) = add(fit) {
                        return none;
                    }
                }
            }
            fit => {
                if let Some(none) = add(fit) {
                    return none;
                }
            }
        }
    }
    match (is_degenerate, is_open) {
        (true, _) => FormFit::Degenerate,
        (false, true) => FormFit::Open,
        (false, false) => FormFit::Preserved(entries),
    }
}

/// Whether a form is preserved at states, to within its errors and those of the images.
pub(super) fn holds(images: &[TangentImages], dof: usize, entries: &[Entry]) -> bool {
    let all: Vec<usize> = (0..2 * dof).collect();
    let terms: Vec<Term> = entries.iter().map(|entry| entry.term).collect();
    let values: Vec<f64> = entries.iter().map(|entry| entry.value).collect();
    let errors: Vec<f64> = entries.iter().map(|entry| entry.error).collect();
    equations(images, &all, &terms).hold(&values, &errors)
}

/// The coordinates in parts that the Jacobians do not couple; both coordinates of a degree of freedom are in one part if `of_pairs`, or if
/// a part would have an odd number of coordinates.
fn parts(images: &[TangentImages], dof: usize, of_pairs: bool) -> Vec<Vec<usize>> {
    let mut part: Vec<usize> = (0..2 * dof).collect();
    let join = |part: &mut Vec<usize>, a: usize, b: usize| {
        let (from, to) = (part[a].max(part[b]), part[a].min(part[b]));
        part.iter_mut()
            .filter(|of| **of == from)
            .for_each(|of| *of = to);
    };
    for of in images {
        for (a, (image, errors)) in of.images.iter().zip(&of.errors).enumerate() {
            for (c, (x, error)) in image.iter().zip(errors).enumerate() {
                if c != a && x.abs() > SIGNIFICANT * error {
                    join(&mut part, a, c);
                }
            }
        }
    }
    let size = |part: &[usize], c: usize| part.iter().filter(|of| **of == part[c]).count();
    for i in 0..dof {
        let is_odd = |part: &[usize]| !size(part, i).is_multiple_of(2);
        if of_pairs || is_odd(&part) || !size(&part, dof + i).is_multiple_of(2) {
            join(&mut part, i, dof + i);
        }
    }
    let members = |first: usize| (0..2 * dof).filter(move |&c| part[c] == first);
    let all = (0..2 * dof).map(|first| members.clone()(first).collect::<Vec<usize>>());
    all.filter(|members| !members.is_empty()).collect()
}

impl Term {
    fn constant(pair: (usize, usize)) -> Self {
        Term {
            pair,
            powers: [0; 3],
        }
    }

    /// The derivatives of z_a q^m/(1 + m_a) at these positions that are not 0, each with its coordinate.
    fn gradient(self, q: &[f64]) -> Vec<(usize, f64)> {
        let ((a, _), Term { mut powers, .. }) = (self.pair, self);
        if powers == [0; 3] {
            return vec![(a, 1.0)];
        }
        powers[a] += 1;
        let derivative = |i: usize| {
            let mut lower = powers;
            lower[i] -= 1;
            let factor = f64::from(powers[i]) / f64::from(powers[a]);
            (i, factor * monomial(lower, |i| q[i]))
        };
        let of_q = (0..powers.len()).filter(|&i| powers[i] > 0);
        of_q.map(derivative).collect()
    }
}

/// Σ_k Ω_k (T_k (DΦ u, DΦ v) − T_k (u, v)) = 0 for all terms T_k, and for all tangent vectors u and v that move these coordinates alone.
fn equations(images: &[TangentImages], coordinates: &[usize], terms: &[Term]) -> Equations {
    let mut rows = Vec::new();
    for of in images {
        let is_within = |k: &usize| {
            let mut components = of.vectors[*k].iter().enumerate();
            components.all(|(c, x)| *x == 0.0 || coordinates.contains(&c))
        };
        let vectors: Vec<usize> = (0..of.vectors.len()).filter(is_within).collect();
        for (n, &i) in vectors.iter().enumerate() {
            rows.extend(vectors[n + 1..].iter().map(|&j| (of, i, j)));
        }
    }
    let coefficient = |r: usize, k: usize| {
        let ((of, i, j), term) = (&rows[r], terms[k]);
        let (u, v) = (&of.vectors[*i], &of.vectors[*j]);
        let (x, y) = (&of.images[*i], &of.images[*j]);
        let (e, f) = (&of.errors[*i], &of.errors[*j]);
        let [before, after] = of.positions.each_ref().map(|q| term.gradient(q));
        // The derivative of z_a q^m along a vector, and its error.
        let along = |gradient: &[(usize, f64)], w: &[f64]| -> f64 {
            gradient.iter().map(|&(c, factor)| factor * w[c]).sum()
        };
        let error =
            |w: &[f64]| -> f64 { after.iter().map(|&(c, factor)| factor.abs() * w[c]).sum() };
        let b = term.pair.1;
        let (ux, vy) = (along(&before, u), along(&before, v));
        let (xa, ya, ea, fa) = (along(&after, x), along(&after, y), error(e), error(f));
        let value = xa * y[b] - x[b] * ya - (ux * v[b] - u[b] * vy);
        let terms = (xa * y[b]).abs() + (x[b] * ya).abs() + (ux * v[b]).abs();
        let rounding = MIN_WIDTH * (terms + (u[b] * vy).abs());
        let of_first = ea * (y[b].abs() + f[b]) + xa.abs() * f[b];
        let of_second = e[b] * (ya.abs() + fa) + x[b].abs() * fa;
        (value, of_first + of_second + rounding + f64::MIN_POSITIVE)
    };
    let (count, unknowns) = (rows.len(), terms.len());
    Equations {
        values: DMatrix::from_fn(count, unknowns, |r, k| coefficient(r, k).0),
        errors: DMatrix::from_fn(count, unknowns, |r, k| coefficient(r, k).1),
    }
}

/// The weights of a preserved form Σ c_i dq_i∧dp_i of these coordinates.
fn weights(images: &[TangentImages], dof: usize, coordinates: &[usize]) -> FormFit {
    let dofs = coordinates.iter().filter(|c| **c < dof);
    let terms: Vec<Term> = dofs.map(|&i| Term::constant((i, dof + i))).collect();
    let equations = equations(images, coordinates, &terms);
    let norm = |k: usize| {
        let column = equations.values.column(k);
        let errors = equations.errors.column(k);
        let relative = column.iter().zip(errors.iter()).map(|(x, e)| (x / e).abs());
        relative.fold(1.0, f64::max)
    };
    // If the Jacobian shows a weight well, its unit may be small.
    let norms: Vec<f64> = (0..terms.len()).map(norm).collect();
    let largest = norms.iter().copied().fold(0.0, f64::max);
    let mut units: Vec<f64> = norms
        .iter()
        .map(|norm| (norm / largest).recip().min(1.0 / MIN_SINGULAR_VALUE))
        .collect();
    for _ in 0..UNIT_ROUNDS {
        let space = match equations.solve(&units) {
            Solutions::Space(space) => space,
            Solutions::None { residual } => return FormFit::None { change: residual },
            Solutions::Open => return FormFit::Open,
        };
        let Some(groups) = space.groups() else {
            // A weight is 0 in all solutions, to within its error.
            return match space.errors.iter().all(|error| *error < NEGLIGIBLE) {
                true => FormFit::Degenerate,
                false => FormFit::Open,
            };
        };
        let largest = |group: usize| {
            let of_group = groups.iter().filter(|of| of.0 == group);
            of_group.map(|of| of.1.abs()).fold(0.0, f64::max)
        };
        let factors: Vec<f64> = groups
            .iter()
            .map(|&(group, value)| value / largest(group))
            .collect();
        if factors
            .iter()
            .all(|factor| factor.abs() >= MIN_ENTRY_NEAR_ONE)
        {
            let entry = |k: usize| {
                let (group, value) = groups[k];
                Entry {
                    term: terms[k],
                    value: value * units[k],
                    error: space.errors[k] * units[k],
                    group,
                }
            };
            return FormFit::Preserved((0..terms.len()).map(entry).collect());
        }
        for (unit, factor) in units.iter_mut().zip(factors) {
            *unit *= factor.abs().max(MIN_SINGULAR_VALUE);
        }
    }
    FormFit::Open
}

/// Any preserved form of these coordinates: the one that is nearest to the canonical one, if there are several.
fn general(images: &[TangentImages], dof: usize, coordinates: &[usize]) -> FormFit {
    let pairs: Vec<(usize, usize)> = (coordinates.iter().enumerate())
        .flat_map(|(k, &a)| coordinates[k + 1..].iter().map(move |&b| (a, b)))
        .collect();
    let terms: Vec<Term> = pairs.iter().copied().map(Term::constant).collect();
    let equations = equations(images, coordinates, &terms);
    let place = |c: usize| coordinates.iter().position(|of| *of == c).unwrap_or(0);
    let mut scale = vec![1.0; coordinates.len()];
    for round in 0..UNIT_ROUNDS {
        let units: Vec<f64> = (pairs.iter())
            .map(|&(a, b)| scale[place(a)] * scale[place(b)])
            .collect();
        let space = match equations.solve(&units) {
            Solutions::Space(space) => space,
            Solutions::None { residual } => return FormFit::None { change: residual },
            Solutions::Open => return FormFit::Open,
        };
        let matrix = |of: &[f64]| {
            let mut matrix = DMatrix::zeros(coordinates.len(), coordinates.len());
            for (&(a, b), x) in pairs.iter().zip(of) {
                matrix[(place(a), place(b))] = *x;
                matrix[(place(b), place(a))] = -x;
            }
            matrix
        };
        let canonical: Vec<f64> = (pairs.iter().zip(&units))
            .map(|(&(a, b), unit)| if b == a + dof { 1.0 / unit } else { 0.0 })
            .collect();
        let Some(form) = candidates(&space, &canonical)
            .into_iter()
            .find(|form| !is_degenerate(&matrix(form)))
        else {
            // Or its units are not known yet.
            return FormFit::Open;
        };
        let largest = |k: usize| matrix(&form).row(k).amax();
        let factors: Vec<f64> = (0..coordinates.len()).map(largest).collect();
        if factors.iter().all(|x| *x >= MIN_ENTRY_NEAR_ONE) || round + 1 == UNIT_ROUNDS {
            return FormFit::Preserved(entries(&form, &space, &terms, &units));
        }
        for (scale, factor) in scale.iter_mut().zip(factors) {
            *scale *= factor.sqrt().max(MIN_SINGULAR_VALUE);
        }
    }
    FormFit::Open
}

/// The form Σ c_i dq_i∧dp_i + Σ B_ij(q) dq_i∧dq_j with polynomials B_ij of low degree that has no other terms: closed ones alone are tried.
pub(super) fn with_field(images: &[TangentImages], dof: usize) -> FormFit {
    let mut terms: Vec<Term> = (0..dof).map(|i| Term::constant((i, dof + i))).collect();
    for powers in powers(dof) {
        // Every closed form is a sum of these: z_a is the first factor of the polynomial, and q_b not its first one.
        let first = (0..dof).find(|&i| powers[i] > 0).unwrap_or(dof);
        for a in 0..=first.min(dof - 1) {
            terms.extend((a + 1..dof).map(|b| Term {
                pair: (a, b),
                powers,
            }));
        }
    }
    let all: Vec<usize> = (0..2 * dof).collect();
    let units = vec![1.0; terms.len()];
    let space = match equations(images, &all, &terms).solve(&units) {
        Solutions::Space(space) => space,
        Solutions::None { residual } => return FormFit::None { change: residual },
        Solutions::Open => return FormFit::Open,
    };
    let canonical: Vec<f64> = (0..terms.len())
        .map(|k| if k < dof { 1.0 } else { 0.0 })
        .collect();
    let is_form = |form: &Vec<f64>| {
        form[..dof]
            .iter()
            .all(|weight| weight.abs() > MIN_SINGULAR_VALUE)
    };
    match candidates(&space, &canonical).into_iter().find(is_form) {
        Some(form) => FormFit::Preserved(entries(&form, &space, &terms, &units)),
        None => FormFit::Open,
    }
}

/// All powers of the first coordinates of at most the largest degree.
fn powers(dof: usize) -> impl Iterator<Item = [u8; 3]> {
    let up_to = move |i: usize| 0..=if i < dof { MAX_DEGREE } else { 0 };
    let all =
        up_to(0).flat_map(move |a| up_to(1).flat_map(move |b| up_to(2).map(move |c| [a, b, c])));
    all.filter(|powers| powers.iter().sum::<u8>() <= MAX_DEGREE)
}

/// The terms of a form that are not 0.
fn entries(form: &[f64], space: &NullSpace, terms: &[Term], units: &[f64]) -> Vec<Entry> {
    let most = form.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let (errors, part) = MAX_ZERO_ENTRY;
    let is_entry = |&k: &usize| form[k].abs() > (errors * space.errors[k]).max(part * most);
    let entry = |k: usize| Entry {
        term: terms[k],
        value: form[k] * units[k],
        error: space.errors[k] * units[k],
        group: 0,
    };
    (0..terms.len()).filter(is_entry).map(entry).collect()
}

/// Whether the Jacobians are the same at all states.
pub(super) fn are_equal(images: &[TangentImages]) -> bool {
    let mut pairs = images.windows(2);
    pairs.all(|pair| {
        let values = pair[0]
            .images
            .iter()
            .flatten()
            .zip(pair[1].images.iter().flatten());
        let errors = pair[0]
            .errors
            .iter()
            .flatten()
            .zip(pair[1].errors.iter().flatten());
        let mut both = values.zip(errors);
        both.all(|((a, b), (of_a, of_b))| {
            (a - b).abs() <= of_a + of_b + MIN_WIDTH * (a.abs() + b.abs())
        })
    })
}

/// Forms of a space with a largest entry of 1: the one nearest to the canonical one, and others.
fn candidates(space: &NullSpace, canonical: &[f64]) -> Vec<Vec<f64>> {
    let (count, dimension) = space.basis.shape();
    let canonical = DMatrix::from_column_slice(count, 1, canonical);
    let nearest = space.basis.transpose() * &canonical / canonical.norm().max(f64::MIN_POSITIVE);
    let other = DMatrix::from_fn(dimension, 1, |k, _| {
        0.5 + (GOLDEN_RATIO * (k + 1) as f64).fract()
    });
    let forms = [nearest.clone(), &nearest + 0.25 * &other, other];
    let scaled = |coefficients: &DMatrix<f64>| {
        let form = &space.basis * coefficients;
        let largest = form.amax();
        (form / largest.max(f64::MIN_POSITIVE))
            .iter()
            .copied()
            .collect::<Vec<f64>>()
    };
    forms.iter().map(scaled).collect()
}

fn is_degenerate(matrix: &DMatrix<f64>) -> bool {
    if matrix.iter().any(|x| !x.is_finite()) {
        return true;
    }
    let singular = matrix.clone().singular_values();
    singular.min() <= MIN_SINGULAR_VALUE * singular.max()
}
