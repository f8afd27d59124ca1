//! Which processors the inner loops are compiled for.

/// A function of which there is one version for each kind of processor; the best is chosen at run
/// time, once. In its body the type parameter is the [`Arithmetic`] of that kind.
///
/// All functions that it calls must be `#[inline(always)]`: anything else is compiled for any processor.
///
/// [`Arithmetic`]: super::Arithmetic
macro_rules! dispatched {
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident<$arithmetic:ident>($($argument:ident: $type:ty),* $(,)?)
            $(-> $output:ty)? $body:block
    ) => {
        $(#[$attribute])*
        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
            "x86_64+avx2+fma",
        ))]
        $visibility fn $name($($argument: $type),*) $(-> $output)? {
            #[inline(always)]
            fn body<$arithmetic: $crate::elementary::Arithmetic>(
                $($argument: $type),*
            ) $(-> $output)? $body

            if multiversion::target::target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
                body::<$crate::elementary::FusedArithmetic>($($argument),*)
            } else {
                body::<$crate::elementary::SeparateArithmetic>($($argument),*)
            }
        }
    };
}

pub(crate) use dispatched;
