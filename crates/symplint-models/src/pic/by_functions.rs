//! From the number of functions on a cell to code that is compiled for it.

/// Calls a function for the number of functions on a cell, which the compiler then knows.
macro_rules! for_functions {
    ($functions:expr, $object:ident.$function:ident::<$dimension:tt>($($argument:expr),*)) => {
        match $functions {
            2 => $object.$function::<$dimension, 2>($($argument),*),
            3 => $object.$function::<$dimension, 3>($($argument),*),
            4 => $object.$function::<$dimension, 4>($($argument),*),
            5 => $object.$function::<$dimension, 5>($($argument),*),
            6 => $object.$function::<$dimension, 6>($($argument),*),
            functions => unreachable!("no shape has {functions} functions on a cell"),
        }
    };
}

pub(super) use for_functions;
