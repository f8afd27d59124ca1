//! Options that take one number for all degrees of freedom, or one for each.

use crate::failure::Failure;

/// The values of an option for each of `dof` degrees of freedom; none where the option was not given.
///
/// # Errors
/// If the number of values is not 1 or `dof`.
pub fn per_dof(option: &str, values: &[f64], dof: usize) -> Result<Option<Vec<f64>>, Failure> {
    match values {
        [] => Ok(None),
        _ if values.len() == 1 || values.len() == dof => Ok(Some(spread(values, dof))),
        _ => Err(Failure::Usage {
            message: format!(
                "{option} has {} numbers for {dof} degrees of freedom",
                values.len()
            ),
            remedy: "give one number for all, or one for each degree of freedom".into(),
        }),
    }
}

/// One value for all, repeated; others unchanged.
pub fn spread(values: &[f64], dof: usize) -> Vec<f64> {
    match values {
        [one] => vec![*one; dof],
        _ => values.to_vec(),
    }
}
