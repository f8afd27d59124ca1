//! The tests of this crate in one program, which is linked once. The test of memory is another program: it counts what the
//! whole program takes.

mod block_width;
mod causes;
mod closures;
mod constraints;
mod dual;
mod failing_steps;
mod field;
mod groups;
mod hostile;
mod jacobian;
mod judge;
mod measured;
mod modules;
mod no_step_size;
mod one_form;
mod piecewise;
mod prefetch;
mod preserved_form;
mod properties;
mod recorded;
mod repeated_states;
mod rules;
mod singular;
mod stopped;
mod streaming;
mod tangent;
mod torus;
mod verdict;
