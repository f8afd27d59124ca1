! A pendulum, by the Verlet method and by the explicit Euler method: which one is symplectic?
!
!   make -C crates/symplint-c install PREFIX=$HOME/.local
!   export PKG_CONFIG_PATH=$HOME/.local/lib/pkgconfig LD_LIBRARY_PATH=$HOME/.local/lib
!   gfortran $HOME/.local/include/symplint.f90 examples/fortran/pendulum.f90 $(pkg-config --libs symplint) -o pendulum
!   ./pendulum
module steps
    use, intrinsic :: iso_c_binding
    implicit none
contains
    ! All samples, one step.
    function verlet(user, h, dof, samples, q, p) bind(c) result(status)
        type(c_ptr), value :: user
        real(c_double), value :: h
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(inout) :: q(samples, dof), p(samples, dof)
        integer(c_int) :: status
        p = p - 0.5d0*h*sin(q)
        q = q + h*p
        p = p - 0.5d0*h*sin(q)
        status = 0
    end function

    function euler(user, h, dof, samples, q, p) bind(c) result(status)
        type(c_ptr), value :: user
        real(c_double), value :: h
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(inout) :: q(samples, dof), p(samples, dof)
        real(c_double) :: force(samples, dof)
        integer(c_int) :: status
        force = -sin(q)
        q = q + h*p
        p = p + h*force
        status = 0
    end function
end module

program pendulum
    use symplint
    use steps
    implicit none
    integer(c_int) :: of_verlet, of_euler
    of_verlet = check('Verlet', c_funloc(verlet))
    of_euler = check('Euler', c_funloc(euler))
    if (of_verlet /= symplint_verdict_symplectic .or. of_euler /= symplint_verdict_not_symplectic) stop 1
contains
    function check(name, step) result(verdict)
        character(len=*), intent(in) :: name
        type(c_funptr), value :: step
        integer(c_int) :: verdict
        type(symplint_options) :: options
        type(c_ptr) :: report
        verdict = symplint_verdict_none
        if (symplint_options_init(options, c_sizeof(options)) /= symplint_status_ok) stop 2
        options%budget = 4000
        options%radius = 0.5d0
        ! One degree of freedom, and the centre (q0, p0) of the loop.
        if (symplint_check(step, c_null_ptr, 1_c_size_t, [1d0], [0.5d0], &
                           options, report) /= symplint_status_ok) then
            print '(a)', name//': '//symplint_text(symplint_last_error())
            return
        end if
        verdict = symplint_report_verdict(report)
        print '(a)', name//': '//symplint_text(symplint_report_summary(report))
        call symplint_report_free(report)
    end function
end program
