//! Numbers from Python objects, and blocks from arrays of any order.

use numpy::ndarray::{Array2, ArrayView1, ArrayView2, Dimension, Ix1, Ix2, s};
use numpy::{
    PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use symplint::Ensemble;
use symplint::state::RowsMut;

use crate::error::input_error;
use crate::memory::Number;

/// Degrees of freedom and samples that are copied together: a cache line of each. Larger tiles of arrays in C order whose rows are a
/// power of two apart push their own lines out of the cache.
const TILE: (usize, usize) = (8, 16);

/// Copies numbers, and says whether all of them are finite.
pub fn copy<T: Number>(to: &mut [f64], from: &[T]) -> bool {
    // Zero times a finite number is zero, and NaN otherwise. Several sums, so that they are vectorised.
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (mut to, mut from) = (to.chunks_exact_mut(LANES), from.chunks_exact(LANES));
    for (to, from) in to.by_ref().zip(from.by_ref()) {
        for lane in 0..LANES {
            let value = from[lane].value();
            to[lane] = value;
            sums[lane] += 0.0 * value;
        }
    }
    for (to, from) in to.into_remainder().iter_mut().zip(from.remainder()) {
        *to = from.value();
        sums[0] += 0.0 * *to;
    }
    sums.iter().sum::<f64>() == 0.0
}

/// Copies `source`, of one row for each sample, into rows of one for each degree of freedom, and says whether all numbers
/// are finite.
pub fn transpose<T: Number>(source: ArrayView2<'_, T>, rows: &mut RowsMut<'_>) -> bool {
    let (samples, dof) = source.dim();
    // Samples side by side, as in the arrays that steps get and in what NumPy makes of them.
    if source.strides()[0] == 1 {
        let of_row = |finite, i| {
            let column = source.column(i);
            finite
                & copy(
                    rows.row_mut(i),
                    column.as_slice().expect("values side by side"),
                )
        };
        return (0..dof).fold(true, of_row);
    }
    let mut finite = true;
    let mut tile = [[0.0; TILE.1]; TILE.0];
    for begin in (0..samples).step_by(TILE.1) {
        let of_tile = begin..samples.min(begin + TILE.1);
        for first in (0..dof).step_by(TILE.0) {
            let dofs = first..dof.min(first + TILE.0);
            let numbers = source.slice(s![of_tile.clone(), dofs.clone()]);
            for (k, sample) in numbers.outer_iter().enumerate() {
                // Of a known length, the copy has no loop.
                match sample.to_slice().and_then(|line| line.first_chunk()) {
                    Some(line) => of_line(&mut tile, k, line),
                    None => {
                        for (row, value) in tile.iter_mut().zip(sample) {
                            row[k] = value.value();
                        }
                    }
                }
            }
            for (i, row) in dofs.zip(&tile) {
                finite &= copy(&mut rows.row_mut(i)[of_tile.clone()], &row[..of_tile.len()]);
            }
        }
    }
    finite
}

/// Copies a cache line of a sample into the rows of a tile.
fn of_line<T: Number>(tile: &mut [[f64; TILE.1]; TILE.0], k: usize, line: &[T; TILE.0]) {
    for (row, value) in tile.iter_mut().zip(line) {
        row[k] = value.value();
    }
}

/// The result of a function instead of (q, p): two objects. `remedy` says what it should do.
pub fn pair<'py>(
    result: Bound<'py, PyAny>,
    what: &str,
    remedy: &str,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    if let Ok(tuple) = result.cast::<PyTuple>()
        && tuple.len() == 2
    {
        return Ok((tuple.get_item(0)?, tuple.get_item(1)?));
    }
    // One array for both, of any library.
    let is_array = result.is_instance_of::<PyUntypedArray>()
        || result.hasattr("__dlpack__")?
        || result.hasattr("__array__")?;
    let stacked = (is_array || result.is_instance_of::<PyList>())
        && result.len().is_ok_and(|length| length == 2);
    if stacked {
        return Ok((result.get_item(0)?, result.get_item(1)?));
    }
    let found = match result.len() {
        Ok(length) => format!("{} of length {length}", result.get_type().name()?),
        Err(_) => result.get_type().name()?.to_string(),
    };
    Err(PyTypeError::new_err(format!(
        "{what} returned an object of type {found}; {remedy}"
    )))
}

/// An array of numbers from whatever has some: lists, arrays of other libraries, arrays of other types.
fn numbers<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = object.py();
    py.import("symplint._arrays")?
        .getattr("numbers")?
        .call1((object, name))
}

/// The array that an object is, if it is of this type and number of axes, aligned, and of no derived class, which may
/// have another meaning.
fn plain<'a, 'py, T: Number, D: Dimension>(
    object: &'a Bound<'py, PyAny>,
) -> Option<&'a Bound<'py, PyArray<T, D>>> {
    let is_base = object
        .get_type()
        .is(object.py().get_type::<PyUntypedArray>());
    let array = object.cast::<PyArray<T, D>>().ok().filter(|_| is_base)?;
    let mut strides = array.strides().iter();
    let aligned = array.data().addr().is_multiple_of(align_of::<T>())
        && strides.all(|stride| stride.unsigned_abs().is_multiple_of(align_of::<T>()));
    aligned.then_some(array)
}

/// Copies the coordinates of all samples, the first ones of an array with `length` rows, into rows of one for each degree of
/// freedom, and returns whether all are finite.
///
/// # Errors
/// If it is of another shape, or of something else than numbers.
pub fn read_rows(
    object: &Bound<'_, PyAny>,
    name: &str,
    rows: &mut RowsMut<'_>,
    length: usize,
) -> PyResult<bool> {
    let dof = rows.count();
    if let Some(array) = plain::<f64, Ix2>(object) {
        return read_array(array.try_readonly()?, name, rows, length);
    }
    if let Some(array) = plain::<f32, Ix2>(object) {
        return read_array(array.try_readonly()?, name, rows, length);
    }
    let array = numbers(object, name)?;
    // One degree of freedom needs no second axis.
    let array = match array.cast::<PyArray1<f64>>() {
        Ok(array) if dof == 1 => array.reshape([PyUntypedArrayMethods::len(array), 1])?,
        _ => array
            .cast_into::<PyArray2<f64>>()
            .map_err(|error| wrong_shape(name, &error.into_inner(), (length, dof)))?,
    };
    read_array(array.try_readonly()?, name, rows, length)
}

fn read_array<T: Number>(
    array: PyReadonlyArray2<'_, T>,
    name: &str,
    rows: &mut RowsMut<'_>,
    length: usize,
) -> PyResult<bool> {
    let expected = (length, rows.count());
    let view = array.as_array();
    if view.dim() != expected {
        return Err(wrong_shape(name, array.as_any(), expected));
    }
    let samples = s![..rows.len(), ..];
    Ok(transpose(view.slice(samples), rows))
}

fn wrong_shape(name: &str, array: &Bound<'_, PyAny>, expected: (usize, usize)) -> PyErr {
    let shape = match array.getattr("shape") {
        Ok(shape) => shape.to_string(),
        Err(error) => return error,
    };
    let (samples, dof) = expected;
    PyValueError::new_err(format!(
        "{name} has the shape {shape}, and should have the shape ({samples}, {dof}): one row for each sample, one \
         column for each degree of freedom"
    ))
}

/// Copies the coordinates of one sample into its column of the rows.
///
/// # Errors
/// If there are more or fewer than degrees of freedom, or it is something else than numbers.
pub fn read_column(
    object: &Bound<'_, PyAny>,
    name: &str,
    rows: &mut RowsMut<'_>,
    sample: usize,
) -> PyResult<()> {
    if let Some(array) = plain::<f64, Ix1>(object) {
        return read_vector(array.try_readonly()?, name, rows, sample);
    }
    if let Some(array) = plain::<f32, Ix1>(object) {
        return read_vector(array.try_readonly()?, name, rows, sample);
    }
    let array = numbers(object, name)?;
    let array = match array.getattr("ndim")?.extract::<usize>()? {
        0 => array.call_method1("reshape", (1,))?,
        _ => array,
    };
    match array.cast_into::<PyArray1<f64>>() {
        Ok(array) => read_vector(array.try_readonly()?, name, rows, sample),
        Err(error) => Err(wrong_length(name, &error.into_inner(), rows.count())),
    }
}

fn read_vector<T: Number>(
    array: PyReadonlyArray1<'_, T>,
    name: &str,
    rows: &mut RowsMut<'_>,
    sample: usize,
) -> PyResult<()> {
    let view: ArrayView1<'_, T> = array.as_array();
    if view.len() != rows.count() {
        return Err(wrong_length(name, array.as_any(), rows.count()));
    }
    for (i, value) in view.iter().enumerate() {
        rows.row_mut(i)[sample] = value.value();
    }
    Ok(())
}

fn wrong_length(name: &str, array: &Bound<'_, PyAny>, dof: usize) -> PyErr {
    match array.getattr("shape") {
        Ok(shape) => PyValueError::new_err(format!(
            "{name} has the shape {shape}, and should have the shape ({dof},): one number for each degree of freedom"
        )),
        Err(error) => error,
    }
}

/// Whether q and p are of one shape.
///
/// # Errors
/// If their shapes differ.
pub fn check_shapes(
    py: Python<'_>,
    q: &PyReadonlyArray2<'_, f64>,
    p: &PyReadonlyArray2<'_, f64>,
) -> PyResult<()> {
    let (q, p) = (q.as_array(), p.as_array());
    if q.dim() != p.dim() {
        let message = format!(
            "q has the shape {:?} and p the shape {:?}; give one row for each sample and one column for each degree \
             of freedom in both",
            q.dim(),
            p.dim()
        );
        return Err(input_error(py, &message));
    }
    Ok(())
}

/// States from two arrays of one row for each sample.
///
/// # Errors
/// If their shapes differ.
pub fn ensemble(
    py: Python<'_>,
    q: &PyReadonlyArray2<'_, f64>,
    p: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Ensemble> {
    check_shapes(py, q, p)?;
    let (q, p) = (q.as_array(), p.as_array());
    let (samples, dof) = q.dim();
    let mut states = Ensemble::zeros(dof, samples);
    let mut block = states.block();
    transpose(q, &mut block.q);
    transpose(p, &mut block.p);
    Ok(states)
}

/// Positions and momenta of one row for each sample.
pub type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// States as two arrays.
pub fn arrays<'py>(py: Python<'py>, states: &Ensemble) -> Arrays<'py> {
    let of = |rows: symplint::state::Rows<'_>| {
        let array = Array2::from_shape_fn((rows.len(), rows.count()), |(k, i)| rows.row(i)[k]);
        PyArray2::from_owned_array(py, array)
    };
    (of(states.q()), of(states.p()))
}
