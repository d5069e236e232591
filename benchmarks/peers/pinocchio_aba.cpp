// Pinocchio's articulated-body algorithm behind the plain C signature; headers only, so built for this machine.
#include <pinocchio/multibody.hpp>
#include <pinocchio/multibody/joint.hpp>
#include <pinocchio/algorithm/aba.hpp>

#include <memory>
#include <string>

namespace {
std::unique_ptr<pinocchio::Model> model;
std::unique_ptr<pinocchio::Data> data;
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
}

extern "C" void peer_forward_dynamics(const double *q, const double *v, const double *u, double *a)
{
    using ConstVector = Eigen::Map<const Eigen::VectorXd>;
    const int n = model->nv;
    Eigen::Map<Eigen::VectorXd>(a, n) = pinocchio::aba(*model, *data, ConstVector(q, n), ConstVector(v, n),
                                                       ConstVector(u, n), pinocchio::Convention::LOCAL);
}
