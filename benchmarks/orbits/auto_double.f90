! Paper A's double pendulum, m = l = 1/2, masses at the middles, in absolute angles, for AUTO-07p: closed form and exact Jacobians.
! U = (phi_1, phi_2, phi_1', phi_2').  IPS = 4: a quarter period, PAR(1) = T, PAR(2) = phi_1(0).  IPS = 2: a period, PAR(11) = T.

      SUBROUTINE PENDULUM(U,F,J)
      IMPLICIT NONE
      DOUBLE PRECISION, INTENT(IN) :: U(4)
      DOUBLE PRECISION, INTENT(OUT) :: F(4), J(4,4)
      DOUBLE PRECISION, PARAMETER :: A=0.15625D0, B=0.0625D0, C=0.03125D0, G1=9.81D0*0.375D0, G2=9.81D0*0.125D0
      DOUBLE PRECISION S, K, R1, R2, D, DR1(4), DR2(4), DK(4)
      S=SIN(U(1)-U(2)); K=B*COS(U(1)-U(2)); S=B*S
      D=1/(A*C-K*K)
      R1=-S*U(4)**2-G1*SIN(U(1)); R2=S*U(3)**2-G2*SIN(U(2))
      F(1)=U(3); F(2)=U(4)
      F(3)=(C*R1-K*R2)*D; F(4)=(A*R2-K*R1)*D
      DK=(/-S,S,0D0,0D0/)
      DR1=(/-K*U(4)**2-G1*COS(U(1)),K*U(4)**2,0D0,-2*S*U(4)/)-DK*F(4)
      DR2=(/K*U(3)**2,-K*U(3)**2-G2*COS(U(2)),2*S*U(3),0D0/)-DK*F(3)
      J=0; J(1,3)=1; J(2,4)=1
      J(3,:)=(C*DR1-K*DR2)*D; J(4,:)=(A*DR2-K*DR1)*D
      END SUBROUTINE PENDULUM

      SUBROUTINE FUNC(NDIM,U,ICP,PAR,IJAC,F,DFDU,DFDP)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM,NDIM), DFDP(NDIM,*)
      DOUBLE PRECISION J(4,4)
      CALL PENDULUM(U,F,J)
      IF (IJAC/=0) DFDU=J
      IF (PAR(3)>0) THEN
! a quarter period on the unit interval
        IF (IJAC==2) THEN
          DFDP(:,1)=F/4; DFDP(:,2)=0
        END IF
        IF (IJAC/=0) DFDU=DFDU*PAR(1)/4
        F=F*PAR(1)/4
      ELSE
! the damper that unfolds the energy
        F(3:4)=F(3:4)-PAR(4)*U(3:4)
        IF (IJAC/=0) THEN
          DFDU(3,3)=DFDU(3,3)-PAR(4); DFDU(4,4)=DFDU(4,4)-PAR(4)
        END IF
        IF (IJAC==2) THEN
          DFDP(1:2,4)=0; DFDP(3:4,4)=-U(3:4)
        END IF
      END IF
      END SUBROUTINE FUNC

      SUBROUTINE STPNT(NDIM,U,PAR,T)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(IN) :: T
      DOUBLE PRECISION X, W
      DOUBLE PRECISION, PARAMETER :: PI=4*ATAN(1D0)
      DOUBLE PRECISION OMEGA, RATIO, FORM
      OPEN(77,FILE='start'); READ(77,*) OMEGA, RATIO, FORM; CLOSE(77)
      PAR(2)=0.01D0; PAR(3)=FORM; PAR(4)=0; PAR(1)=2*PI/OMEGA; PAR(11)=PAR(1)
      X=2*PI*T; IF (FORM>0) X=X/4
      W=OMEGA
      U=(/COS(X),RATIO*COS(X),-W*SIN(X),-W*RATIO*SIN(X)/)*PAR(2)
      END SUBROUTINE STPNT

      SUBROUTINE BCND(NDIM,PAR,ICP,NBC,U0,U1,FB,IJAC,DBC)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), NBC, IJAC
      DOUBLE PRECISION, INTENT(IN) :: PAR(*), U0(NDIM), U1(NDIM)
      DOUBLE PRECISION, INTENT(OUT) :: FB(NBC)
      DOUBLE PRECISION, INTENT(INOUT) :: DBC(NBC,*)
      FB=(/U0(3),U0(4),U1(1),U1(2),U0(1)-PAR(2)/)
      IF (IJAC/=0) THEN
        DBC(:,1:2*NDIM+2)=0
        DBC(1,3)=1; DBC(2,4)=1; DBC(3,5)=1; DBC(4,6)=1; DBC(5,1)=1; DBC(5,2*NDIM+2)=-1
      END IF
      END SUBROUTINE BCND

      SUBROUTINE ICND
      END SUBROUTINE ICND

      SUBROUTINE FOPT
      END SUBROUTINE FOPT

      SUBROUTINE PVLS(NDIM,U,PAR)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: PAR(*)
      DOUBLE PRECISION, EXTERNAL :: GETP
      IF (PAR(3)==0) PAR(2)=GETP('BV0',1,U)
      END SUBROUTINE PVLS
