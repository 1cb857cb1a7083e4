#include "controller/horizon/feedback.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace c3rt::horizon {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEveryState = 1e-6;  // weight of each state, of the largest in Q and Q_N
constexpr double kForces = 1e6;       // weight of a force, of the states that it moves in one step
constexpr double kInputs = 1e-8;      // the same, the least weight of an input
constexpr double kRank = 1e-9;        // of the rows that the modes keep at zero
constexpr double kHarmless = 1e2;     // growth that needs no feedback

/// What ν = [u; λ] costs for its own sake. Units: of the cost, whatever those of forces are.
MatrixXd input_weight(const MatrixXd& R, const MatrixXd& B_hat, const MatrixXd& Q) {
  MatrixXd W = MatrixXd::Zero(B_hat.cols(), B_hat.cols());
  W.topLeftCorner(R.rows(), R.cols()) = R;
  for (Index j = 0; j < B_hat.cols(); ++j) {
    const double moved = B_hat.col(j).dot(Q * B_hat.col(j));
    W(j, j) += j < R.cols() ? kInputs * moved : kForces * moved;
    if (W(j, j) == 0.0) W(j, j) = 1.0;
  }
  return W;
}

/// The ν that keep the zero sides of stage k: ν = N x + Z η.
struct Kept {
  MatrixXd N, Z;
};

Kept kept(const lcs::Lcs& lcs, const Side* zero) {
  const Index n_x = lcs.A.rows(), n_lambda = lcs.F.rows(), n_u = lcs.B.cols(), n = n_u + n_lambda;
  Kept result{MatrixXd::Zero(n, n_x), MatrixXd::Identity(n, n)};
  if (zero == nullptr || n_lambda == 0) return result;
  MatrixXd G = MatrixXd::Zero(n_lambda, n), E = MatrixXd::Zero(n_lambda, n_x);
  for (Index j = 0; j < n_lambda; ++j) {
    if (zero[j] == Side::kForce) {
      G(j, n_u + j) = 1.0;
      continue;
    }
    G.row(j) << lcs.H.row(j), lcs.F.row(j);
    const double length = G.row(j).norm();
    if (length == 0.0) continue;
    G.row(j) /= length;
    E.row(j) = lcs.E.row(j) / length;
  }
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(kRank);
  decomposition.compute(G);
  result.N = -decomposition.solve(E);
  // what is left of a ν when the rows' part is taken out; an orthonormal basis of it
  const MatrixXd rest = MatrixXd::Identity(n, n) - decomposition.solve(G);
  Eigen::ColPivHouseholderQR<MatrixXd> basis(rest);
  result.Z = MatrixXd(basis.householderQ()).leftCols(n - decomposition.rank());
  return result;
}

MatrixXd closed(const lcs::Lcs& lcs, const MatrixXd& K) {
  MatrixXd A = lcs.A;
  A.noalias() += lcs.B * K.topRows(lcs.B.cols());
  A.noalias() += lcs.D * K.bottomRows(lcs.D.cols());
  return A;
}

/// How much a state grows on the way. Inf or NaN beyond double precision.
double growth(const Problem& problem, const std::vector<MatrixXd>& K) {
  MatrixXd transition = MatrixXd::Identity(problem.sizes.n_x, problem.sizes.n_x);
  double largest = 0.0;
  for (int k = 0; k < problem.sizes.N; ++k) {
    transition = (closed(problem.systems[k], K[k]) * transition).eval();
    const double length = transition.norm();
    if (!(length <= largest)) largest = length;
  }
  return largest;
}

}  // namespace

std::vector<MatrixXd> stabilising_feedback(const Problem& problem, const std::vector<Side>& zero) {
  const auto [n_x, n_lambda, n_u, N] = problem.sizes;
  const int n = n_u + n_lambda;
  std::vector<MatrixXd> none(N, MatrixXd::Zero(n, n_x));
  std::vector<MatrixXd> gains = none, held = none;
  double heaviest = problem.costs->Q_N.diagonal().maxCoeff();
  for (int k = 0; k < N; ++k)
    heaviest = std::max(heaviest, problem.costs->Q[k].diagonal().maxCoeff());
  if (!(heaviest > 0.0)) heaviest = 1.0;
  const MatrixXd every = kEveryState * heaviest * MatrixXd::Identity(n_x, n_x);

  MatrixXd P = problem.costs->Q_N + every, B_hat(n_x, n);
  for (int k = N - 1; k >= 0; --k) {
    const lcs::Lcs& lcs = problem.systems[k];
    B_hat << lcs.B, lcs.D;
    const MatrixXd Q = problem.costs->Q[k] + every;
    const MatrixXd R = input_weight(problem.costs->R[k], B_hat, Q);
    const Kept ways = kept(lcs, zero.empty() ? nullptr : zero.data() + k * n_lambda);
    const MatrixXd A = lcs.A + B_hat * ways.N, B = B_hat * ways.Z, PB = P * B, RZ = R * ways.Z;
    const Eigen::LLT<MatrixXd> factor(ways.Z.transpose() * RZ + B.transpose() * PB);
    if (factor.info() != Eigen::Success) return none;
    const MatrixXd eta = factor.solve(PB.transpose() * A + RZ.transpose() * ways.N);
    held[k] = ways.N;
    gains[k] = ways.N - ways.Z * eta;
    const MatrixXd A_closed = lcs.A + B_hat * gains[k];
    const MatrixXd weighted = P * A_closed;
    P = Q + gains[k].transpose() * R * gains[k] + A_closed.transpose() * weighted;
    P = 0.5 * (P + P.transpose()).eval();
    if (!P.allFinite()) return none;
  }
  const double without = growth(problem, held);
  if (without <= kHarmless) return none;
  const double with = growth(problem, gains);
  return !(without <= with) ? gains : none;
}

}  // namespace c3rt::horizon
