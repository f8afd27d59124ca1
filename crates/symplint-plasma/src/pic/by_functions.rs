//! From the number of functions on a cell to code that is compiled for it.

/// Calls a function for the number of functions on a cell, which the compiler then knows.
macro_rules! for_functions {
    ($functions:expr, $object:ident.$function:ident($($argument:expr),*)) => {
        match $functions {
            2 => $object.$function::<2>($($argument),*),
            3 => $object.$function::<3>($($argument),*),
            4 => $object.$function::<4>($($argument),*),
            5 => $object.$function::<5>($($argument),*),
            6 => $object.$function::<6>($($argument),*),
            functions => unreachable!("no shape has {functions} functions on a cell"),
        }
    };
}

pub(super) use for_functions;
