! A force in two dimensions, and the same with a part that is not a gradient: which one has a potential?
!
!   make -C crates/symplint-c install PREFIX=$HOME/.local
!   export PKG_CONFIG_PATH=$HOME/.local/lib/pkgconfig LD_LIBRARY_PATH=$HOME/.local/lib
!   gfortran $HOME/.local/include/symplint.f90 examples/fortran/force.f90 $(pkg-config --libs symplint) -o force
!   ./force
module forces
    use, intrinsic :: iso_c_binding
    implicit none
contains
    ! Of Henon and Heiles, at all samples.
    function gradient(user, dof, samples, q, force) bind(c) result(status)
        type(c_ptr), value :: user
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(in) :: q(samples, dof)
        real(c_double), intent(out) :: force(samples, dof)
        integer(c_int) :: status
        force(:, 1) = -q(:, 1) - 2*q(:, 1)*q(:, 2)
        force(:, 2) = -q(:, 2) - q(:, 1)**2 + q(:, 2)**2
        status = 0
    end function

    function with_curl(user, dof, samples, q, force) bind(c) result(status)
        type(c_ptr), value :: user
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(in) :: q(samples, dof)
        real(c_double), intent(out) :: force(samples, dof)
        integer(c_int) :: status
        status = gradient(user, dof, samples, q, force)
        force(:, 1) = force(:, 1) - 1d-6*q(:, 2)
        force(:, 2) = force(:, 2) + 1d-6*q(:, 1)
    end function

    ! A particle with friction: the rates of q and p.
    function friction(user, dof, samples, q, p, q_rate, p_rate) bind(c) result(status)
        type(c_ptr), value :: user
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(in) :: q(samples, dof), p(samples, dof)
        real(c_double), intent(out) :: q_rate(samples, dof), p_rate(samples, dof)
        integer(c_int) :: status
        status = gradient(user, dof, samples, q, p_rate)
        q_rate = p
        p_rate = p_rate - 0.01d0*p
    end function
end module

program force
    use symplint
    use forces
    implicit none
    real(c_double), parameter :: q0(2) = [0.3d0, 0.1d0], p0(2) = [0.2d0, -0.1d0]
    type(symplint_field_options) :: options
    type(c_ptr) :: report
    integer(c_int) :: status
    if (symplint_field_options_init(options, c_sizeof(options)) /= symplint_status_ok) stop 2
    options%radius = 0.2d0
    status = symplint_check_force(c_funloc(gradient), c_null_ptr, 2_c_size_t, q0, options, report)
    call expect('gradient', symplint_field_verdict_holds)
    status = symplint_check_force(c_funloc(with_curl), c_null_ptr, 2_c_size_t, q0, options, report)
    call expect('with curl', symplint_field_verdict_fails)
    status = symplint_check_field(c_funloc(friction), c_null_ptr, 2_c_size_t, q0, p0, options, report)
    call expect('friction', symplint_field_verdict_fails)
contains
    subroutine expect(name, verdict)
        character(len=*), intent(in) :: name
        integer(c_int), intent(in) :: verdict
        if (status /= symplint_status_ok) then
            print '(a)', name//': '//symplint_text(symplint_last_error())
            stop 3
        end if
        print '(a)', name//': '//symplint_text(symplint_field_report_summary(report))
        if (symplint_field_report_verdict(report) /= verdict) stop 1
        call symplint_field_report_free(report)
    end subroutine
end program
