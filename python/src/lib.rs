//! The sampler for Python: see `pmcip.pyi` for what everything does.
//!
//! Arrays of the library's go to numpy as they are, and numpy's are read where they are if they are contiguous. While the
//! library works, other Python threads run.

use numpy::ndarray::{Dimension, IxDyn};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray, PyReadonlyArray1,
    PyUntypedArrayMethods,
};
use pmcip::Film as Owned;
use pmcip::error::Error;
use pmcip_core::predict::Prior;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::sampler::wave::{self, Piece};
use pmcip_core::sampler::{Mode, Schedule, Settings};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// What the library refuses is a `ValueError`.
fn refused(error: Error) -> PyErr {
    match error {
        Error::Work(text) => PyRuntimeError::new_err(text),
        error => PyValueError::new_err(error.to_string()),
    }
}

fn estimator(name: &str) -> PyResult<Estimator> {
    match name {
        "pooled" => Ok(Estimator::Pooled),
        "subframe" => Ok(Estimator::Subframe),
        "difference" => Ok(Estimator::Difference),
        "balanced" => Ok(Estimator::Balanced),
        _ => Err(PyValueError::new_err("estimator must be pooled, subframe, difference or balanced")),
    }
}

/// The entries of an array, row by row, where they are.
fn entries<'a, T: Element, D: Dimension>(
    array: &'a PyReadonlyArray<'_, T, D>,
    what: &str,
) -> PyResult<&'a [T]> {
    let entries = array.as_slice().ok().filter(|_| array.is_c_contiguous());
    entries.ok_or_else(|| PyValueError::new_err(format!("{what} must be contiguous, row by row")))
}

/// Floats of an array that are `number` times `channels`, the last dimension, if that is more than one.
fn floats<'a>(array: &'a Any<'_>, number: usize, channels: usize, what: &str) -> PyResult<&'a [f32]> {
    let floats = entries(array, what)?;
    let shaped = channels == 1 || array.shape().last() == Some(&channels);
    match shaped && floats.len() == number * channels {
        true => Ok(floats),
        false => Err(PyValueError::new_err(format!(
            "{what} must have {number} entries of {channels} numbers, not the shape {:?}",
            array.shape()
        ))),
    }
}

type Any<'py> = PyReadonlyArray<'py, f32, IxDyn>;

/// Samples of an iteration.
#[pyclass(frozen, module = "pmcip")]
struct Plan {
    piece: Piece,
    #[pyo3(get)]
    x: Py<PyArray1<f32>>,
    #[pyo3(get)]
    y: Py<PyArray1<f32>>,
    #[pyo3(get)]
    index: Py<PyArray1<u32>>,
    #[pyo3(get)]
    key: Py<PyArray1<u32>>,
}

#[pymethods]
impl Plan {
    #[getter]
    fn end(&self) -> usize {
        self.piece.end
    }

    fn __len__(&self) -> usize {
        self.piece.samples
    }

    fn points<'py>(
        &self,
        py: Python<'py>,
        set: u32,
    ) -> PyResult<(Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>)> {
        let (index, key) = (self.index.bind(py).readonly(), self.key.bind(py).readonly());
        points(py, set, index, key)
    }
}

/// Points of any set.
#[pyfunction]
fn points<'py>(
    py: Python<'py>,
    set: u32,
    index: PyReadonlyArray1<'py, u32>,
    key: PyReadonlyArray1<'py, u32>,
) -> PyResult<(Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<f32>>)> {
    let (index, key) = (entries(&index, "index")?, entries(&key, "key")?);
    let (mut u, mut v) = (vec![0.0; index.len()], vec![0.0; index.len()]);
    py.detach(|| wave::points(set, index, key, &mut u, &mut v));
    Ok((u.into_pyarray(py), v.into_pyarray(py)))
}

/// A film.
#[pyclass(module = "pmcip")]
struct Film {
    film: Owned,
    width: usize,
    height: usize,
}

impl Film {
    fn picture<'py>(&self, py: Python<'py>, rgb: Vec<[f32; 3]>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        rgb.into_flattened().into_pyarray(py).reshape([self.height, self.width, 3])
    }

    fn plane<'py, T: Element>(&self, py: Python<'py>, plane: Vec<T>) -> PyResult<Bound<'py, PyArray2<T>>> {
        plane.into_pyarray(py).reshape([self.height, self.width])
    }

    fn area(&self) -> usize {
        self.width * self.height
    }
}

#[pymethods]
impl Film {
    #[new]
    #[pyo3(signature = (width, height, *, spp=0, pilot=2, labels=None, seed=0, frame=0, cd_per_unit=100.0, uniform=false, gamma=None, epsilon=None, fair=None))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn new(
        width: u32,
        height: u32,
        spp: u32,
        pilot: u32,
        labels: Option<PyReadonlyArray<'_, u16, IxDyn>>,
        seed: u32,
        frame: u32,
        cd_per_unit: f32,
        uniform: bool,
        gamma: Option<f32>,
        epsilon: Option<f32>,
        fair: Option<u32>,
    ) -> PyResult<Self> {
        let base = Settings::new(width, height);
        let settings = Settings {
            seed,
            frame,
            cd_per_unit,
            mode: if uniform { Mode::Uniform } else { Mode::Adaptive },
            gamma: gamma.unwrap_or(base.gamma),
            epsilon: epsilon.unwrap_or(base.epsilon),
            fair: fair.unwrap_or(base.fair),
            ..base
        };
        let film = match &labels {
            None => Owned::new(settings.for_frame(pilot, spp)),
            Some(labels) => {
                let labels = entries(labels, "labels")?;
                let used = labels.iter().filter(|label| **label != 0).count() as u64;
                Owned::with_labels(settings.for_pixels(used, pilot, spp), labels)
            }
        };
        Ok(Film { film: film.map_err(refused)?, width: width as usize, height: height as usize })
    }

    #[staticmethod]
    fn load(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let film = py.detach(|| Owned::load(data)).map_err(refused)?;
        let (width, height) = (film.settings().width as usize, film.settings().height as usize);
        Ok(Film { film, width, height })
    }

    fn save<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.film.save()).map_err(refused)?;
        Ok(PyBytes::new(py, &bytes))
    }

    #[getter]
    fn pixels(&self) -> u64 {
        self.film.pixels()
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.height, self.width)
    }

    #[staticmethod]
    fn schedule(pixels: u64, spp: u32, pilot: u32, iterations: u32) -> Vec<u64> {
        Schedule::new(pixels, spp, pilot, iterations).collect()
    }

    #[pyo3(signature = (samples, alpha=None))]
    fn begin(&mut self, py: Python<'_>, samples: u64, alpha: Option<Any<'_>>) -> PyResult<()> {
        let alpha = alpha.as_ref().map(|alpha| floats(alpha, self.area(), 1, "alpha")).transpose()?;
        let prior = alpha.map_or(Prior::Beliefs(&[]), Prior::Alpha);
        py.detach(|| self.film.begin_predicted(samples, prior)).map_err(refused)
    }

    #[pyo3(signature = (first=0, most=None))]
    fn plan(&mut self, py: Python<'_>, first: usize, most: Option<usize>) -> PyResult<Plan> {
        let plan = py.detach(|| self.film.plan(first, most.unwrap_or(usize::MAX))).map_err(refused)?;
        Ok(Plan {
            piece: plan.piece,
            x: plan.x.into_pyarray(py).unbind(),
            y: plan.y.into_pyarray(py).unbind(),
            index: plan.index.into_pyarray(py).unbind(),
            key: plan.key.into_pyarray(py).unbind(),
        })
    }

    fn deliver(&mut self, py: Python<'_>, plan: &Plan, rgb: Any<'_>) -> PyResult<()> {
        let (rgb, _) = floats(&rgb, plan.piece.samples, 3, "rgb")?.as_chunks::<3>();
        py.detach(|| self.film.deliver(plan.piece, rgb)).map_err(refused)?;
        Ok(())
    }

    fn end(&mut self) -> PyResult<(u64, u64)> {
        let tally = self.film.end().map_err(refused)?;
        Ok((tally.samples, tally.rejected))
    }

    #[pyo3(signature = (radiance, spp, *, pilot=2, iterations=8, most=None))]
    fn render(
        &mut self,
        py: Python<'_>,
        radiance: Bound<'_, PyAny>,
        spp: u32,
        pilot: u32,
        iterations: u32,
        most: Option<usize>,
    ) -> PyResult<()> {
        for samples in Schedule::new(self.pixels(), spp, pilot, iterations) {
            self.begin(py, samples, None)?;
            let mut first = 0;
            while first < self.area() {
                let plan = Py::new(py, self.plan(py, first, most)?)?;
                first = plan.get().end();
                if plan.get().piece.samples > 0 {
                    let rgb: Any<'_> = radiance.call1((&plan,))?.extract().map_err(|_| {
                        PyValueError::new_err(
                            "the radiance must be a float32 array of three numbers a sample",
                        )
                    })?;
                    self.deliver(py, plan.get(), rgb)?;
                }
            }
            self.end()?;
        }
        Ok(())
    }

    #[pyo3(signature = (estimator="balanced"))]
    fn resolve<'py>(&mut self, py: Python<'py>, estimator: &str) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let estimator = crate::estimator(estimator)?;
        let rgb = py.detach(|| self.film.resolve(estimator)).map_err(refused)?;
        self.picture(py, rgb)
    }

    #[pyo3(signature = (albedo=None, normal=None, depth=None))]
    fn guided<'py>(
        &mut self,
        py: Python<'py>,
        albedo: Option<Any<'py>>,
        normal: Option<Any<'py>>,
        depth: Option<Any<'py>>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let area = self.area();
        let three = |array: &'_ Option<Any<'py>>, what| -> PyResult<Vec<[f32; 3]>> {
            array.as_ref().map_or(Ok(vec![]), |a| Ok(floats(a, area, 3, what)?.as_chunks::<3>().0.to_vec()))
        };
        let (albedo, normal) = (three(&albedo, "albedo")?, three(&normal, "normal")?);
        let depth = depth.as_ref().map_or(Ok(&[][..]), |depth| floats(depth, area, 1, "depth"))?;
        let feature = |i: usize| Feature {
            albedo: albedo.get(i).copied().unwrap_or([1.0; 3]),
            normal: normal.get(i).copied().unwrap_or_default(),
            depth: depth.get(i).copied().unwrap_or_default(),
        };
        let features: Vec<Feature> = (0..area).map(feature).collect();
        let rgb = py.detach(|| self.film.guided(&features)).map_err(refused)?;
        self.picture(py, rgb)
    }

    fn resolve_guided<'py>(
        &mut self,
        py: Python<'py>,
        guide: Any<'py>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let (guide, _) = floats(&guide, self.area(), 3, "guide")?.as_chunks::<3>();
        let rgb = py.detach(|| self.film.resolve_guided(guide)).map_err(refused)?;
        self.picture(py, rgb)
    }

    fn variance<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let plane = py.detach(|| self.film.variance()).map_err(refused)?;
        self.plane(py, plane)
    }

    fn count<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let plane = py.detach(|| self.film.count()).map_err(refused)?;
        self.plane(py, plane)
    }

    fn alpha<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let plane = py.detach(|| self.film.alpha()).map_err(refused)?;
        self.plane(py, plane)
    }
}

/// The module.
#[pymodule]
#[pyo3(name = "pmcip")]
fn contents(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_class::<Film>()?;
    m.add_class::<Plan>()?;
    m.add_function(wrap_pyfunction!(points, m)?)
}
