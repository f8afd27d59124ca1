//! The systems and integrators of the library.

use std::path::Path;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use symplint::TimeAdvance;
use symplint_config::document::{Table, parse};
use symplint_config::{Kind, SYSTEMS, read_integrator, read_system};
use symplint_models::integrators::aliases::ALIASES;
use symplint_plasma::CATALOGUE;

use crate::arrays;
use crate::error::{config_error, diagnostic_error, input_error};
use crate::pool;

/// The system that calls programs. It removes its files and ends its processes when it is dropped or at a signal, and Python
/// promises neither.
const NOT_HERE: &str = "command";

/// A system with an initial state.
#[pyclass(frozen, module = "symplint._native")]
pub struct System {
    inner: symplint_config::System,
    resolved: toml::Table,
}

#[pymethods]
impl System {
    /// The system of this name.
    #[new]
    fn new(py: Python<'_>, name: &str, keys: &Bound<'_, PyDict>) -> PyResult<Self> {
        if name == NOT_HERE {
            let message = "the system \"command\" is one of the program symplint; here, pass a function that calls the \
                 program to symplint.check, or run `symplint check`";
            return Err(input_error(py, message));
        }
        let keys = table(py, name, keys)?;
        let (inner, resolved) =
            read_system(keys, Path::new("")).map_err(|e| config_error(py, &e))?;
        Ok(System { inner, resolved })
    }

    /// Its name in configurations.
    #[getter]
    fn name(&self) -> &'static str {
        self.inner.name
    }

    /// Degrees of freedom.
    #[getter]
    fn dof(&self) -> usize {
        self.inner.q0.len()
    }

    /// Initial positions.
    #[getter]
    fn q0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.q0)
    }

    /// Initial momenta.
    #[getter]
    fn p0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.p0)
    }

    /// All keys with their values, defaults included, as JSON.
    fn config(&self) -> String {
        json(&self.resolved)
    }

    fn __repr__(&self) -> String {
        format!("<symplint system {}>", self.inner.name)
    }
}

/// One step of a method for a system.
#[pyclass(frozen, module = "symplint._native")]
pub struct Integrator {
    pub map: Arc<dyn TimeAdvance>,
    system: Py<System>,
    name: String,
    resolved: toml::Table,
}

type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl Integrator {
    /// The method of this name for a system; the default method of the system without one.
    #[new]
    fn new(
        py: Python<'_>,
        name: Option<&str>,
        system: Py<System>,
        keys: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let keys = match name {
            Some(name) => table(py, name, keys)?,
            None => Table::default(),
        };
        let made = read_integrator(keys, &system.get().inner).map_err(|e| config_error(py, &e))?;
        Ok(Integrator {
            map: made.map,
            system,
            name: made.name,
            resolved: made.resolved,
        })
    }

    /// Its name, with variant.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// The system.
    #[getter]
    fn system(&self, py: Python<'_>) -> Py<System> {
        self.system.clone_ref(py)
    }

    /// Degrees of freedom.
    #[getter]
    fn dof(&self) -> usize {
        self.map.dof()
    }

    /// All keys with their values, defaults included, as JSON.
    fn config(&self) -> String {
        json(&self.resolved)
    }

    /// Advances states by one step of size h.
    fn advance<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
        p: PyReadonlyArray2<'py, f64>,
        h: f64,
    ) -> PyResult<Arrays<'py>> {
        let mut states = arrays::ensemble(py, &q, &p)?;
        if states.dof() != self.map.dof() {
            let message = format!(
                "the arrays have {} columns and the system {} degrees of freedom; they must agree",
                states.dof(),
                self.map.dof()
            );
            return Err(input_error(py, &message));
        }
        let map = Arc::clone(&self.map);
        let advanced = pool::run(py, move || states.advance(&*map, h).map(|()| states))?;
        let states = advanced.map_err(|error| diagnostic_error(py, &error))?;
        Ok(arrays::arrays(py, &states))
    }

    fn __repr__(&self) -> String {
        format!("<symplint integrator {}>", self.name)
    }
}

/// All systems as (name, summary, keys), with keys as (name, default or None, help, kind, texts); integrators as (name, summary, reference, variants,
/// whether stages are solved); and aliases as (name, integrator, variants).
#[pyfunction]
pub fn catalogue(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let of_python = SYSTEMS.iter().filter(|info| info.name != NOT_HERE);
    let systems = of_python.map(|info| {
        let keys: Vec<_> = (info.keys.iter())
            .map(|key| {
                let (kind, texts): (_, &[&str]) = match key.kind {
                    Kind::Plain => ("plain", &[]),
                    Kind::Numbers => ("numbers", &[]),
                    Kind::Choice(texts) => ("choice", texts),
                    Kind::ChoiceOrFile(texts) => ("choice-or-file", texts),
                };
                let default = (!key.optional).then_some(key.value);
                (key.name, default, key.help, kind, texts.to_vec())
            })
            .collect();
        (info.name, info.summary, keys)
    });
    let integrators = CATALOGUE.iter().map(|info| {
        let variants = info.variants.to_vec();
        (
            info.name,
            info.summary,
            info.reference,
            variants,
            info.is_implicit(),
        )
    });
    let aliases =
        (ALIASES.iter()).map(|alias| (alias.name, alias.integrator, alias.variants.to_vec()));
    let all = PyDict::new(py);
    all.set_item("systems", systems.collect::<Vec<_>>())?;
    all.set_item("integrators", integrators.collect::<Vec<_>>())?;
    all.set_item("aliases", aliases.collect::<Vec<_>>())?;
    Ok(all)
}

fn json(table: &toml::Table) -> String {
    serde_json::to_string(table).expect("tables of numbers and texts")
}

/// Keyword arguments as the table of a configuration, with the key `name`.
fn table(py: Python<'_>, name: &str, keys: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut table = toml::Table::new();
    table.insert("name".into(), name.into());
    for (key, item) in keys {
        let key: String = key.extract()?;
        let item = value(&key, &item)?;
        table.insert(key, item);
    }
    parse("keyword arguments", table.to_string()).map_err(|error| config_error(py, &error))
}

/// A Python value as one of a configuration.
fn value(key: &str, object: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if object.is_instance_of::<PyBool>() {
        return Ok(toml::Value::Boolean(object.extract()?));
    }
    if object.is_instance_of::<PyInt>() {
        return Ok(toml::Value::Integer(object.extract()?));
    }
    if object.is_instance_of::<PyFloat>() {
        return Ok(toml::Value::Float(object.extract()?));
    }
    if object.is_instance_of::<PyString>() {
        return Ok(toml::Value::String(object.extract()?));
    }
    if let Ok(items) = object.cast::<PyDict>() {
        let entry = |(key, item): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let key: String = key.extract()?;
            let item = value(&key, &item)?;
            Ok((key, item))
        };
        return Ok(toml::Value::Table(
            items.iter().map(entry).collect::<PyResult<_>>()?,
        ));
    }
    let sequence = object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>();
    if sequence || object.hasattr("tolist")? {
        let list = match sequence {
            true => object.clone(),
            false => object.call_method0("tolist")?,
        };
        if !list.is_instance_of::<PyList>() && !list.is_instance_of::<PyTuple>() {
            return value(key, &list);
        }
        let items = list.try_iter()?.map(|item| value(key, &item?));
        return Ok(toml::Value::Array(items.collect::<PyResult<_>>()?));
    }
    if object.hasattr("__fspath__")? {
        let path = object.call_method0("__fspath__")?;
        return Ok(toml::Value::String(path.extract()?));
    }
    let found = object.get_type().name()?;
    let message =
        format!("{key} is an object of type {found}; give a number, a text, a list or a dict");
    Err(input_error(object.py(), &message))
}
