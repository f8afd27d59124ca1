! A leapfrog step of pendula as a program: symplint check examples/command/fortran.toml
! gfortran -O2 leapfrog.f90 -o leapfrog
program leapfrog
  implicit none
  character(256) :: before, after, word
  double precision, allocatable :: q(:, :), p(:, :)
  double precision :: h
  integer :: dof, samples
  call get_command_argument(1, before)
  call get_command_argument(2, after)
  open (10, file=before)
  read (10, *) word, h, dof, samples
  allocate (q(samples, dof), p(samples, dof))
  read (10, *) q, p
  q = q + 0.5d0*h*p
  p = p - h*sin(q)
  q = q + 0.5d0*h*p
  open (11, file=after)
  write (11, *) 'symplint', h, dof, samples
  write (11, '(es25.17e3)') q, p
end program
