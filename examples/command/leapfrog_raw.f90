! The same with doubles instead of decimals: symplint check examples/command/fortran.toml --set system.format=raw
! gfortran -O2 leapfrog_raw.f90 -o leapfrog_raw
program leapfrog_raw
  implicit none
  character(256) :: before, after, line, word
  double precision, allocatable :: q(:, :), p(:, :)
  double precision :: h
  integer :: dof, samples, start
  call get_command_argument(1, before)
  call get_command_argument(2, after)
  open (10, file=before, access='stream', form='formatted')
  read (10, '(a)') line
  inquire (10, pos=start)
  close (10)
  read (line, *) word, h, dof, samples
  allocate (q(samples, dof), p(samples, dof))
  open (10, file=before, access='stream')
  read (10, pos=start) q, p
  q = q + 0.5d0*h*p
  p = p - h*sin(q)
  q = q + 0.5d0*h*p
  open (11, file=after, access='stream', status='replace')
  write (11) trim(line), new_line('a'), q, p
end program
