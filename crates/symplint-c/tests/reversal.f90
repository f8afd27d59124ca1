! A Verlet step of a pendulum whose momentum stands still at 1: no signs reverse it in time, but p -> 2 - p does.
module steps
    use, intrinsic :: iso_c_binding
    implicit none
contains
    function verlet(user, h, dof, samples, q, p) bind(c) result(status)
        type(c_ptr), value :: user
        real(c_double), value :: h
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(inout) :: q(samples, dof), p(samples, dof)
        integer(c_int) :: status
        p = p - 0.5d0*h*sin(q)
        q = q + h*(p - 1)
        p = p - 0.5d0*h*sin(q)
        status = 0
    end function

    function reversed(user, dof, samples, q, p) bind(c) result(status)
        type(c_ptr), value :: user
        integer(c_size_t), value :: dof, samples
        real(c_double), intent(inout) :: q(samples, dof), p(samples, dof)
        integer(c_int) :: status
        p = 2 - p
        status = 0
    end function
end module

program reversal
    use symplint
    use steps
    implicit none
    call check(c_null_funptr, '"text": "not time-reversible')
    call check(c_funloc(reversed), '"text": "time-reversible (step, the given reversal, step')
contains
    subroutine check(reversal_function, expected)
        type(c_funptr), intent(in) :: reversal_function
        character(len=*), intent(in) :: expected
        type(symplint_options) :: options
        type(c_ptr) :: report
        if (symplint_options_init(options, c_sizeof(options)) /= symplint_status_ok) stop 2
        options%radius = 0.5d0
        options%reversal_function = reversal_function
        if (symplint_check(c_funloc(verlet), c_null_ptr, 1_c_size_t, [1d0], [1.5d0], options, report) /= symplint_status_ok) stop 3
        if (index(symplint_text(symplint_report_json(report)), expected) == 0) stop 4
        call symplint_report_free(report)
    end subroutine
end program
