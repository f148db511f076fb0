//! The exceptions, and which core error becomes which.
//!
//! Holds no messages of its own but those of mistakes that only Python can make (a wrong type, a panic).

use std::any::Any;

use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyTimeoutError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};
use smooth_polylines_core as core;

/// One Python class for each way to fail.
struct Exceptions {
    error: Py<PyType>,
    mesh: Py<PyType>,
    option: Py<PyType>,
    no_path: Py<PyType>,
    collapsed: Py<PyType>,
    cut: Py<PyType>,
    limit: Py<PyType>,
    internal: Py<PyType>,
}

/// Made at import, once a process.
static EXCEPTIONS: PyOnceLock<Exceptions> = PyOnceLock::new();

fn define<'py>(py: Python<'py>, name: &str, doc: &str, bases: &[&Bound<'py, PyType>]) -> PyResult<Bound<'py, PyType>> {
    let namespace = PyDict::new(py);
    // The package's name, not the extension's: exceptions are pickled and printed by it.
    namespace.set_item("__module__", "smooth_polylines")?;
    namespace.set_item("__doc__", doc)?;
    let class = py.get_type::<PyType>().call1((name, PyTuple::new(py, bases)?, namespace))?;
    Ok(class.cast_into::<PyType>()?)
}

fn exceptions(py: Python<'_>) -> PyResult<&Exceptions> {
    EXCEPTIONS.get_or_try_init(py, || {
        let exception = py.get_type::<PyException>();
        let value_error = py.get_type::<PyValueError>();
        let error = define(
            py,
            "Error",
            "Base of every error that this package raises about meshes and lines.\n\n\
             Wrong types and ranks of arguments are TypeError instead.",
            &[&exception],
        )?;
        let mesh = define(
            py,
            "MeshError",
            "The mesh cannot be used: an index out of range, a position that is not finite, a triangle that repeats a \
             vertex.\n\nThe message names the first offender.",
            &[&error, &value_error],
        )?;
        let option = define(
            py,
            "OptionError",
            "An argument is out of its range, or arguments contradict each other.\n\nThe message names the argument.",
            &[&error, &value_error],
        )?;
        let no_path = define(
            py,
            "NoPathError",
            "Two consecutive picks lie on parts of the mesh that are not connected.",
            &[&error],
        )?;
        let collapsed = define(py, "CollapsedError", "A closed line shrank to a point.", &[&error])?;
        let cut = define(py, "CutError", "Lines could not be put into the mesh.", &[&error])?;
        let timeout_error = py.get_type::<PyTimeoutError>();
        let limit = define(
            py,
            "LimitError",
            "A call was ended by its `time_limit` or by its `stop`; nothing half finished is returned.",
            &[&error, &timeout_error],
        )?;
        let internal = define(py, "InternalError", "A defect of this package: please report it.", &[&error])?;
        Ok(Exceptions {
            error: error.unbind(),
            mesh: mesh.unbind(),
            option: option.unbind(),
            no_path: no_path.unbind(),
            collapsed: collapsed.unbind(),
            cut: cut.unbind(),
            limit: limit.unbind(),
            internal: internal.unbind(),
        })
    })
}

/// Adds the classes to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    let all = exceptions(py)?;
    for class in [&all.error, &all.mesh, &all.option, &all.no_path, &all.collapsed, &all.cut, &all.limit, &all.internal]
    {
        let class = class.bind(py);
        module.add(class.name()?, class)?;
    }
    Ok(())
}

fn raise(py: Python<'_>, choose: impl FnOnce(&Exceptions) -> &Py<PyType>, message: String) -> PyErr {
    match exceptions(py) {
        Ok(all) => PyErr::from_type(choose(all).bind(py).clone(), message),
        Err(error) => error,
    }
}

/// The exception of a core error. `Interrupted` becomes KeyboardInterrupt where no better cause is known.
pub fn from_core(py: Python<'_>, error: core::Error) -> PyErr {
    let message = error.to_string();
    match error {
        core::Error::Mesh(_) => raise(py, |all| &all.mesh, message),
        core::Error::Option(_) => raise(py, |all| &all.option, message),
        core::Error::NoPath { .. } => raise(py, |all| &all.no_path, message),
        core::Error::Collapsed { .. } => raise(py, |all| &all.collapsed, message),
        core::Error::Tangled { .. } => raise(py, |all| &all.cut, message),
        core::Error::Interrupted => PyKeyboardInterrupt::new_err(message),
    }
}

/// A LimitError.
pub fn limit_error(py: Python<'_>, message: String) -> PyErr {
    raise(py, |all| &all.limit, message)
}

/// An OptionError about `argument`.
pub fn option_error(py: Python<'_>, argument: &'static str, message: impl Into<String>) -> PyErr {
    from_core(py, core::OptionError::new(argument, message).into())
}

/// A TypeError about `argument`.
pub fn type_error(argument: &str, message: impl std::fmt::Display) -> PyErr {
    PyTypeError::new_err(format!("{argument}: {message}"))
}

/// What a panic becomes: an error that can be caught, where pyo3's own PanicException could not be.
pub fn internal_error(py: Python<'_>, panic: &(dyn Any + Send)) -> PyErr {
    let told = panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned());
    raise(
        py,
        |all| &all.internal,
        format!(
            "internal error: {told}; this is a defect of smooth_polylines {}: please report it with the mesh and the \
             arguments",
            env!("CARGO_PKG_VERSION")
        ),
    )
}
