//! The numbers of the search for a preserved form.

/// Degrees of freedom up to which all constant forms are tried. Derived: 2d² unknowns, 276 then, take less than a second.
pub(super) const MAX_DOF_OF_ALL_FORMS: usize = 12;

/// Degrees of freedom up to which weights and signs are tried. Derived: as many unknowns take less than a second.
pub(super) const MAX_DOF_OF_WEIGHTS: usize = 400;

/// Evaluations at most. Conventional.
pub(super) const MAX_EVALUATIONS: usize = 2000;

/// Samples of a loop that confirms a form at most.
pub(super) const MAX_SAMPLES: usize = 256;

/// States with all columns of the Jacobian: the last one confirms the form of the others. Of random tangent vectors one state less is
/// enough: the second one confirms the form of the first.
pub(super) const STATES: usize = 3;

/// Random tangent vectors in addition to √(2d): their pairs are 4√(2d) equations more than unknowns.
pub(super) const EXTRA_VECTORS: usize = 4;

/// The largest degree of a field B(q), and the degrees of freedom in which fields are tried. Derived: 29 unknowns in three dimensions.
pub(super) const MAX_DEGREE: u8 = 2;
pub(super) const DOFS_OF_FIELD: std::ops::RangeInclusive<usize> = 2..=3;

/// Half the width of the interval in which a product of components lies at least, relative. Calibrated: the residual of stages that are
/// solved to round-off makes as much, and no trial of a tangent map shows it.
pub(super) const MIN_WIDTH: f64 = 2e-13;

/// Rounds in which units are found in which all entries of the form are near 1. Derived: one repairs half of the decades.
pub(super) const UNIT_ROUNDS: usize = 6;

/// Entries between this and its inverse are near 1.
pub(super) const MIN_ENTRY_NEAR_ONE: f64 = 0.25;

/// A form is degenerate if its smallest singular value is this part of the largest one in those units. It is also the smallest factor of a
/// unit in one round.
pub(super) const MIN_SINGULAR_VALUE: f64 = 1e-6;

/// An entry of a form is 0 if it is at most this many times its error, or this part of the largest one in its units.
pub(super) const MAX_ZERO_ENTRY: (f64, f64) = (5.0, 1e-9);

/// More samples are not taken if the change of a loop integral is known to this. Derived: a few hundred roundings.
pub(super) const MAX_LOOP_ERROR: f64 = 1e-13;

/// More samples of a loop help if they made the uncertainty of its integral fall by this factor. Conventional: those of a smooth loop make
/// it fall by far more, noise by √2.
pub(super) const MIN_GAIN_OF_DOUBLING: f64 = 4.0;

/// A number with this many digits fewer than its error supports was chosen by a person: one in a thousand others would be as short.
pub(super) const MIN_SAVED_DIGITS: f64 = 3.0;

/// The same if all entries of a group together have twice this number of digits fewer, and at least this number on average.
pub(super) const MIN_MEAN_SAVED_DIGITS: f64 = 1.5;

/// Digits of other numbers in addition to those that their errors support: errors are bounds.
pub(super) const EXTRA_DIGITS: f64 = 2.0;

/// Digits to which a matrix may be rounded. Conventional: people choose numbers with fewer digits, and more digits look like all.
pub(super) const DIGITS_OF_MATRIX: std::ops::RangeInclusive<i32> = 2..=11;

/// Entries that are tried as units.
pub(super) const MAX_UNITS: usize = 48;

/// Added to the seed of the random loops of a diagnosis, for those that refine a form.
pub(super) const SEED_OF_REFINING: u64 = 1 << 40;
