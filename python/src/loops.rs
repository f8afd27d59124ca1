//! Loops as Python objects.

use std::sync::Arc;

use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use symplint::{Circle, Ensemble, FourierLoop, Loop, Phases, SampledLoop};

use crate::arrays;
use crate::coordinates::Stated;
use crate::error::{diagnostic_error, input_error};
use crate::pool;

/// The phases of this name.
pub fn named_phases(py: Python<'_>, name: &str, seed: u64) -> PyResult<Phases> {
    Phases::named(name, seed).ok_or_else(|| {
        let known = Phases::NAMES.map(|name| format!("\"{name}\"")).join(", ");
        input_error(py, &format!("phases is \"{name}\"; give one of {known}"))
    })
}

/// A loop of the library.
#[pyclass(frozen, name = "Loop", module = "symplint._native")]
pub struct NativeLoop {
    pub inner: Arc<dyn Loop>,
}

type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

impl NativeLoop {
    fn new(py: Python<'_>, made: Result<impl Loop + 'static, symplint::Error>) -> PyResult<Self> {
        match made {
            Ok(inner) => Ok(NativeLoop {
                inner: Arc::new(inner),
            }),
            Err(error) => Err(diagnostic_error(py, &error)),
        }
    }
}

#[pymethods]
impl NativeLoop {
    /// An ellipse in every degree of freedom. Phases come by name, with the seed of random ones.
    #[staticmethod]
    #[pyo3(signature = (q0, p0, radii_q, radii_p, dofs, phases))]
    fn circle(
        py: Python<'_>,
        q0: Vec<f64>,
        p0: Vec<f64>,
        radii_q: Vec<f64>,
        radii_p: Vec<f64>,
        dofs: Option<Vec<usize>>,
        phases: (String, u64),
    ) -> PyResult<Self> {
        let made = Circle::with_radii(q0, p0, radii_q, radii_p).and_then(|circle| match dofs {
            Some(dofs) => circle.on(&dofs),
            None => Ok(circle),
        });
        let phases = named_phases(py, &phases.0, phases.1)?;
        Self::new(py, made.map(|circle| circle.with_phases(phases)))
    }

    /// A random loop of three modes.
    #[staticmethod]
    fn fourier(
        py: Python<'_>,
        q0: Vec<f64>,
        p0: Vec<f64>,
        radii_q: Vec<f64>,
        radii_p: Vec<f64>,
        seed: u64,
    ) -> PyResult<Self> {
        Self::new(py, FourierLoop::random(q0, p0, &radii_q, &radii_p, seed))
    }

    /// The trigonometric interpolant of samples.
    #[staticmethod]
    fn sampled(
        py: Python<'_>,
        q: PyReadonlyArray2<'_, f64>,
        p: PyReadonlyArray2<'_, f64>,
        stated: Stated,
    ) -> PyResult<Self> {
        let states = arrays::ensemble(py, &q, &p)?;
        let coordinates = stated.of(py, states.dof())?;
        Self::new(py, SampledLoop::new(states, &coordinates))
    }

    /// Degrees of freedom.
    #[getter]
    fn dof(&self) -> usize {
        self.inner.dof()
    }

    /// Equispaced samples.
    fn sample<'py>(&self, py: Python<'py>, samples: usize) -> PyResult<Arrays<'py>> {
        let inner = Arc::clone(&self.inner);
        let states = pool::run(py, move || Ensemble::sample(&*inner, samples))?;
        let states = states.map_err(|error| diagnostic_error(py, &error))?;
        Ok(arrays::arrays(py, &states))
    }

    /// The states at some parameters s.
    fn at<'py>(&self, py: Python<'py>, s: Vec<f64>) -> Arrays<'py> {
        let mut states = Ensemble::zeros(self.inner.dof(), s.len());
        self.inner.sample(&s, &mut states.block());
        arrays::arrays(py, &states)
    }
}
