//! Memory that Rust and numpy arrays share, and blocks that one thread lends to another. The only file with `unsafe`.
//!
//! Arrays that are lent to a user's function may be kept by it, as they are or as any view of them. So they never lie
//! in the memory of an ensemble, which is freed or used again: they lie in a [`Memory`], a separate Python object that
//! every such array keeps alive. Who wants to use a memory again asks first whether an array still holds it.

use std::cell::UnsafeCell;
use std::ptr::NonNull;
use std::sync::mpsc::SyncSender;

use numpy::ndarray::{ArrayView, ArrayView2, Dimension, ShapeBuilder, StrideShape};
use numpy::{Element, PyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use symplint::Block;
use symplint::state::Rows;

/// Numbers of a type that every pattern of bits is a value of.
pub trait Number: Element + Copy + Send + Sync + 'static {
    /// From double precision, rounded.
    fn of(value: f64) -> Self;
    /// To double precision.
    fn value(self) -> f64;
}

impl Number for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
}

impl Number for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
    fn value(self) -> f64 {
        f64::from(self)
    }
}

/// The numbers of a numpy array, one row for each sample, for as long as this exists. Who made the array may write to it meanwhile,
/// as numpy's own functions let him: what is read then is of no use.
pub struct Samples {
    start: NonNull<f64>,
    /// Samples and degrees of freedom.
    shape: (usize, usize),
    /// Distances of samples and of degrees of freedom, in numbers.
    strides: (usize, usize),
    _array: Py<PyArray2<f64>>,
}

// SAFETY: the memory is only read, and belongs to the array, which any thread may keep alive.
unsafe impl Send for Samples {}
// SAFETY: as above.
unsafe impl Sync for Samples {}

impl Samples {
    /// Of an array; `None` if its numbers are not aligned, or an axis is reversed.
    pub fn of(array: &PyReadonlyArray2<'_, f64>) -> Option<Self> {
        let view = array.as_array();
        let (samples, dofs) = (view.strides()[0], view.strides()[1]);
        let strides = (usize::try_from(samples).ok()?, usize::try_from(dofs).ok()?);
        let start = NonNull::new(view.as_ptr().cast_mut())?;
        start.is_aligned().then(|| Samples {
            start,
            shape: view.dim(),
            strides,
            _array: (**array).clone().unbind(),
        })
    }

    /// The array.
    pub fn view(&self) -> ArrayView2<'_, f64> {
        // SAFETY: `of` found this number of values at these distances, and the array keeps them.
        unsafe { ArrayView2::from_shape_ptr(self.shape.strides(self.strides), self.start.as_ptr()) }
    }

    /// One row for each degree of freedom; `None` if the values of one do not lie side by side.
    pub fn rows(&self) -> Option<Rows<'_>> {
        let values = self.view().reversed_axes().to_slice()?;
        let (samples, dof) = self.shape;
        Some(Rows::new(values, dof, samples, samples))
    }
}

/// Numbers that numpy arrays may refer to, as long as one of them exists.
#[pyclass(frozen, module = "symplint._native")]
pub struct Memory {
    /// Whole words, so that numbers of every type are aligned.
    words: Box<[UnsafeCell<u64>]>,
}

// SAFETY: the words are read and written through `Memory::slice` and `Memory::slice_mut` below, under the conditions
// stated there, and by numpy, whose arrays are shared memory in the same way wherever they come from.
unsafe impl Sync for Memory {}

impl Memory {
    /// Zeros, of 8 bytes each.
    pub fn zeros(words: usize) -> Self {
        Memory {
            words: (0..words).map(|_| UnsafeCell::new(0)).collect(),
        }
    }

    /// How many words there are.
    pub fn words(&self) -> usize {
        self.words.len()
    }

    /// The first number of type `T` from `first` on, of which `count` are there.
    fn start<T: Number>(&self, first: usize, count: usize) -> NonNull<T> {
        let end = first.checked_add(count);
        let bytes = end.and_then(|end| end.checked_mul(size_of::<T>()));
        assert!(
            bytes.is_some_and(|bytes| bytes <= 8 * self.words.len()) && align_of::<T>() <= 8,
            "{count} numbers from {first} on do not fit into {} words",
            self.words.len()
        );
        let start: NonNull<T> = NonNull::from(&*self.words).cast();
        // SAFETY: `first` numbers lie within the words, as was just asserted.
        unsafe { start.add(first) }
    }

    /// Numbers that Rust reads or writes while it holds the interpreter, which arrays may refer to as well.
    ///
    /// `visit` must not call Python.
    pub fn with<T: Number, R>(
        this: &Bound<'_, Self>,
        first: usize,
        count: usize,
        visit: impl FnOnce(&mut [T]) -> R,
    ) -> R {
        let start = this.get().start::<T>(first, count);
        // SAFETY: `count` numbers from `start` on lie within the words, every pattern of bits is a number, and the
        // cells allow writing. The thread is attached to the interpreter and `visit` runs no Python code, so no Python
        // code runs at the same time; as with every numpy array, a function of numpy that runs without the lock
        // in another thread of the user is his to synchronise. Rust has no other access: `this` is not passed to `visit`.
        visit(unsafe { std::slice::from_raw_parts_mut(start.as_ptr(), count) })
    }

    /// A writable array of these numbers that keeps this memory alive. Strides count numbers.
    ///
    /// # Panics
    /// If it reaches beyond the memory.
    pub fn array<'py, T: Number, D: Dimension>(
        this: &Bound<'py, Self>,
        first: usize,
        shape: D,
        strides: D,
    ) -> Bound<'py, PyArray<T, D>> {
        let empty = shape.slice().contains(&0);
        let reach = (shape.slice().iter().zip(strides.slice()))
            .map(|(&length, &stride)| length.saturating_sub(1).saturating_mul(stride))
            .fold(0, usize::saturating_add);
        let start = this
            .get()
            .start::<T>(first, if empty { 0 } else { reach.saturating_add(1) });
        let shape: StrideShape<D> = shape.strides(strides);
        // SAFETY: the last number of the view is `reach` behind the first, and both lie within the words, as `start`
        // asserted; no stride is negative. The view itself is only asked for its shape.
        let view = unsafe { ArrayView::from_shape_ptr(shape, start.as_ptr().cast_const()) };
        // SAFETY: the words stay where they are as long as the object `this` exists, which the array keeps alive; they
        // are cells, so that writing to them is allowed.
        unsafe { PyArray::borrow_from_array(&view, this.clone().into_any()) }
    }

    /// Whether no array refers to this memory: this is the only reference to the object.
    pub fn is_unused(this: &Bound<'_, Self>) -> bool {
        // SAFETY: the object is alive, and the thread attached to the interpreter.
        unsafe { pyo3::ffi::Py_REFCNT(this.as_ptr()) == 1 }
    }
}

/// A block of one thread on loan to another one, and who waits for its return.
///
/// The lender waits until the answer comes, or the loan is dropped.
pub struct Loan<A> {
    block: NonNull<Block<'static>>,
    answer: SyncSender<A>,
}

// SAFETY: a block may be sent, and `lend` prevents any other use of it as long as the loan exists.
unsafe impl<A: Send> Send for Loan<A> {}

impl<A> Loan<A> {
    /// The block, until the loan is used again.
    pub fn block(&mut self) -> Block<'_> {
        // SAFETY: the lender waits in `lend` until this loan is gone, so the block exists and the lender does not use it.
        // The returned block lives no longer than this borrow of the loan.
        unsafe { self.block.as_mut() }.reborrow()
    }

    /// Gives the block back.
    pub fn answer(self, answer: A) {
        // The lender may have panicked meanwhile; then no thread waits.
        let _ = self.answer.send(answer);
    }
}

/// Lends a block to whom `send` passes the loan, and waits for the answer. `None` where the loan was dropped
/// without one.
pub fn lend<A>(block: &mut Block<'_>, send: impl FnOnce(Loan<A>)) -> Option<A> {
    let (answer, answered) = std::sync::mpsc::sync_channel(1);
    // Until this call returns, the borrow of `block` lasts. `recv` returns when the loan is answered, which takes it, or
    // dropped, which drops the only sender; a panic of `send` drops the loan, too, or leaves it with a thread that `Wait`
    // waits for.
    let wait = Wait(answered);
    send(Loan {
        block: NonNull::from(block).cast(),
        answer,
    });
    wait.0.recv().ok()
}

/// Waits until the loan is gone, even if its sender panics.
struct Wait<A>(std::sync::mpsc::Receiver<A>);

impl<A> Drop for Wait<A> {
    fn drop(&mut self) {
        while self.0.recv().is_ok() {}
    }
}
