// Pinocchio's articulated-body algorithm and its derivatives behind the common signature; headers only, so built here.
#include <pinocchio/multibody.hpp>
#include <pinocchio/multibody/joint.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/aba-derivatives.hpp>

#include <memory>
#include <string>

namespace {
using ConstVector = Eigen::Map<const Eigen::VectorXd>;
using Matrix = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
std::unique_ptr<pinocchio::Model> model;
std::unique_ptr<pinocchio::Data> data;
Eigen::VectorXd free_joints;
}

// Point masses at com[k] along links of length[k]; hinges turn about the horizontal axis x, gravity is along -z.
extern "C" void peer_setup(int links, const double *mass, const double *length, const double *com)
{
    model = std::make_unique<pinocchio::Model>();
    pinocchio::JointIndex parent = 0;
    for (int k = 0; k < links; ++k) {
        const Eigen::Vector3d hinge(0, 0, k == 0 ? 0 : -length[k - 1]);
        const pinocchio::SE3 placement(Eigen::Matrix3d::Identity(), hinge);
        parent = model->addJoint(parent, pinocchio::JointModelRX(), placement, "joint" + std::to_string(k));
        const pinocchio::Inertia point(mass[k], Eigen::Vector3d(0, 0, -com[k]), Eigen::Matrix3d::Zero());
        model->appendBodyToJoint(parent, point, pinocchio::SE3::Identity());
    }
    data = std::make_unique<pinocchio::Data>(*model);
    free_joints = Eigen::VectorXd::Zero(links);
}

// state = (q, v, u)
extern "C" void peer_function(double *a, const double *state, const double *, const double *)
{
    const int n = model->nv;
    Eigen::Map<Eigen::VectorXd>(a, n) =
        pinocchio::aba(*model, *data, ConstVector(state, n), ConstVector(state + n, n), ConstVector(state + 2 * n, n),
                       pinocchio::Convention::LOCAL);
}

// state = (q, v), no torques; out = (d a/d q, d a/d v), row-major
extern "C" void peer_jacobian(double *out, const double *state, const double *, const double *)
{
    const int n = model->nv;
    pinocchio::computeABADerivatives(*model, *data, ConstVector(state, n), ConstVector(state + n, n), free_joints);
    Matrix(out, n, n) = data->ddq_dq;
    Matrix(out + n * n, n, n) = data->ddq_dv;
}
