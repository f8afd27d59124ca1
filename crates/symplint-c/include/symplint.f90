! The C interface of symplint for Fortran: compile this file with your code. symplint.h says what everything means.
!
! Arrays of states are q(samples, dof) and p(samples, dof).
module symplint
    use, intrinsic :: iso_c_binding
    implicit none

    enum, bind(c)
        enumerator :: symplint_status_ok = 0, symplint_status_null_pointer = 1, symplint_status_bad_argument = 2
        enumerator :: symplint_status_step_failed = 3, symplint_status_failed = 4, symplint_status_internal = 5
    end enum

    enum, bind(c)
        enumerator :: symplint_verdict_none = -1, symplint_verdict_symplectic = 0, symplint_verdict_not_symplectic = 1
        enumerator :: symplint_verdict_broken_loops = 2, symplint_verdict_undecided = 3
    end enum

    type, bind(c) :: symplint_options
        integer(c_size_t) :: size
        type(c_ptr) :: step_sizes
        integer(c_size_t) :: step_count
        real(c_double) :: typical_step
        real(c_double) :: radius
        type(c_ptr) :: radius_q
        type(c_ptr) :: radius_p
        type(c_ptr) :: period
        type(c_ptr) :: momentum_period
        type(c_ptr) :: weight
        type(c_ptr) :: rule
        integer(c_size_t) :: samples
        integer(c_size_t) :: budget
        integer(c_size_t) :: loops
        integer(c_size_t) :: steps
        integer(c_int64_t) :: seed
        real(c_double) :: tolerance
        integer(c_size_t) :: threads
        integer(c_int32_t) :: jacobian
        integer(c_int32_t) :: localise
        type(c_ptr) :: phases
        integer(c_size_t) :: repeat
        integer(c_int32_t) :: no_step_size
        type(c_ptr) :: reversal
        integer(c_int32_t) :: properties
        integer(c_int32_t) :: symmetric
        type(c_ptr) :: settings
        type(c_funptr) :: substep
        integer(c_size_t) :: substep_count
        type(c_ptr) :: substep_names
        type(c_funptr) :: reversal_function
    end type

    enum, bind(c)
        enumerator :: symplint_field_verdict_none = -1, symplint_field_verdict_holds = 0, symplint_field_verdict_fails = 1
        enumerator :: symplint_field_verdict_undecided = 3
    end enum

    type, bind(c) :: symplint_field_options
        integer(c_size_t) :: size
        real(c_double) :: radius
        type(c_ptr) :: radius_q
        type(c_ptr) :: radius_p
        type(c_ptr) :: period
        type(c_ptr) :: weight
        integer(c_size_t) :: loops
        integer(c_size_t) :: budget
        integer(c_int64_t) :: seed
        integer(c_size_t) :: threads
    end type

    type, bind(c) :: symplint_integral
        real(c_double) :: value, quadrature_error, roundoff, scale
    end type

    type, bind(c) :: symplint_defect_of
        real(c_double) :: signed_defect, quadrature_error, roundoff
    end type

    abstract interface
        function symplint_step(user, h, dof, samples, q, p) bind(c) result(status)
            import
            type(c_ptr), value :: user
            real(c_double), value :: h
            integer(c_size_t), value :: dof, samples
            real(c_double), intent(inout) :: q(samples, dof), p(samples, dof)
            integer(c_int) :: status
        end function

        function symplint_reversal(user, dof, samples, q, p) bind(c) result(status)
            import
            type(c_ptr), value :: user
            integer(c_size_t), value :: dof, samples
            real(c_double), intent(inout) :: q(samples, dof), p(samples, dof)
            integer(c_int) :: status
        end function

        function symplint_force(user, dof, samples, q, force) bind(c) result(status)
            import
            type(c_ptr), value :: user
            integer(c_size_t), value :: dof, samples
            real(c_double), intent(in) :: q(samples, dof)
            real(c_double), intent(out) :: force(samples, dof)
            integer(c_int) :: status
        end function

        function symplint_field(user, dof, samples, q, p, q_rate, p_rate) bind(c) result(status)
            import
            type(c_ptr), value :: user
            integer(c_size_t), value :: dof, samples
            real(c_double), intent(in) :: q(samples, dof), p(samples, dof)
            real(c_double), intent(out) :: q_rate(samples, dof), p_rate(samples, dof)
            integer(c_int) :: status
        end function
    end interface

    interface
        function symplint_check(step, user, dof, q0, p0, options, report) bind(c) result(status)
            import
            type(c_funptr), value :: step
            type(c_ptr), value :: user
            integer(c_size_t), value :: dof
            real(c_double), intent(in) :: q0(dof), p0(dof)
            type(symplint_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: report
            integer(c_int) :: status
        end function

        function symplint_options_init(options, size) bind(c) result(status)
            import
            type(symplint_options), intent(inout) :: options
            integer(c_size_t), value :: size
            integer(c_int) :: status
        end function

        function symplint_check_force(force, user, dof, q0, options, report) bind(c) result(status)
            import
            type(c_funptr), value :: force
            type(c_ptr), value :: user
            integer(c_size_t), value :: dof
            real(c_double), intent(in) :: q0(dof)
            type(symplint_field_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: report
            integer(c_int) :: status
        end function

        function symplint_check_field(field, user, dof, q0, p0, options, report) bind(c) result(status)
            import
            type(c_funptr), value :: field
            type(c_ptr), value :: user
            integer(c_size_t), value :: dof
            real(c_double), intent(in) :: q0(dof), p0(dof)
            type(symplint_field_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: report
            integer(c_int) :: status
        end function

        function symplint_field_options_init(options, size) bind(c) result(status)
            import
            type(symplint_field_options), intent(inout) :: options
            integer(c_size_t), value :: size
            integer(c_int) :: status
        end function

        function symplint_field_report_verdict(report) bind(c) result(verdict)
            import
            type(c_ptr), value :: report
            integer(c_int) :: verdict
        end function

        function symplint_field_report_digits(report) bind(c) result(digits)
            import
            type(c_ptr), value :: report
            real(c_double) :: digits
        end function

        function symplint_field_report_curl(report, error) bind(c) result(curl)
            import
            type(c_ptr), value :: report
            real(c_double), intent(out), optional :: error
            real(c_double) :: curl
        end function

        function symplint_field_report_summary(report) bind(c) result(text)
            import
            type(c_ptr), value :: report
            type(c_ptr) :: text
        end function

        function symplint_field_report_text(report) bind(c) result(text)
            import
            type(c_ptr), value :: report
            type(c_ptr) :: text
        end function

        function symplint_field_report_json(report) bind(c) result(text)
            import
            type(c_ptr), value :: report
            type(c_ptr) :: text
        end function

        subroutine symplint_field_report_free(report) bind(c)
            import
            type(c_ptr), value :: report
        end subroutine

        function symplint_loop_integral(dof, samples, q, p, dof_stride, sample_stride, period, weight, integral) &
            bind(c) result(status)
            import
            integer(c_size_t), value :: dof, samples, dof_stride, sample_stride
            real(c_double), intent(in) :: q(*), p(*)
            real(c_double), intent(in), optional :: period(dof), weight(dof)
            type(symplint_integral), intent(out) :: integral
            integer(c_int) :: status
        end function

        function symplint_partial_integrals(dof, samples, q, p, dof_stride, sample_stride, period, weight, parts) &
            bind(c) result(status)
            import
            integer(c_size_t), value :: dof, samples, dof_stride, sample_stride
            real(c_double), intent(in) :: q(*), p(*)
            real(c_double), intent(in), optional :: period(dof), weight(dof)
            type(symplint_integral), intent(out) :: parts(dof)
            integer(c_int) :: status
        end function

        function symplint_merge_integrals(count, parts, integral) bind(c) result(status)
            import
            integer(c_size_t), value :: count
            type(symplint_integral), intent(in) :: parts(count)
            type(symplint_integral), intent(out) :: integral
            integer(c_int) :: status
        end function

        function symplint_defect(initial, advanced, defect) bind(c) result(status)
            import
            type(symplint_integral), intent(in) :: initial, advanced
            type(symplint_defect_of), intent(out) :: defect
            integer(c_int) :: status
        end function

        function symplint_report_verdict(report) bind(c) result(verdict)
            import
            type(c_ptr), value :: report
            integer(c_int) :: verdict
        end function

        function symplint_report_digits(report) bind(c) result(digits)
            import
            type(c_ptr), value :: report
            real(c_double) :: digits
        end function

        function symplint_report_order(report) bind(c) result(order)
            import
            type(c_ptr), value :: report
            real(c_double) :: order
        end function

        function symplint_report_summary(report) bind(c) result(text)
            import
            type(c_ptr), value :: report
            type(c_ptr) :: text
        end function

        function symplint_report_text(report) bind(c) result(text)
            import
            type(c_ptr), value :: report
            type(c_ptr) :: text
        end function

        function symplint_report_json(report) bind(c) result(text)
            import
            type(c_ptr), value :: report
            type(c_ptr) :: text
        end function

        subroutine symplint_report_free(report) bind(c)
            import
            type(c_ptr), value :: report
        end subroutine

        function symplint_last_error() bind(c) result(text)
            import
            type(c_ptr) :: text
        end function
    end interface

contains

    ! A text of C as one of Fortran.
    function symplint_text(text) result(characters)
        type(c_ptr), intent(in) :: text
        character(len=:), allocatable :: characters
        character(kind=c_char), pointer :: bytes(:)
        integer :: i, length
        interface
            function strlen(text) bind(c) result(length)
                import
                type(c_ptr), value :: text
                integer(c_size_t) :: length
            end function
        end interface
        length = 0
        if (c_associated(text)) length = int(strlen(text))
        allocate (character(len=length) :: characters)
        if (length == 0) return
        call c_f_pointer(text, bytes, [length])
        do i = 1, length
            characters(i:i) = bytes(i)
        end do
    end function
end module
