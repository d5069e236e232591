/* MuJoCo's forward dynamics behind the plain C signature: the minimal pipeline, no contacts or passive forces. */
#include <mujoco/mujoco.h>
#include <string.h>

static const mjModel *model;
static mjData *data;

/* Returns 0, or 1 with the reason in error. */
int peer_setup(const char *path, char *error, int size)
{
    model = mj_loadXML(path, NULL, error, size);
    if (model == NULL)
        return 1;
    data = mj_makeData(model);
    return data == NULL;
}

void peer_forward_dynamics(const double *q, const double *v, const double *u, double *a)
{
    const size_t bytes = (size_t)model->nv * sizeof(double);
    memcpy(data->qpos, q, bytes);
    memcpy(data->qvel, v, bytes);
    mj_kinematics(model, data);
    mj_comPos(model, data);
    mj_makeM(model, data);
    mj_factorM(model, data);
    mj_comVel(model, data);
    mj_rne(model, data, 0, data->qfrc_bias);
    for (int i = 0; i < model->nv; ++i)
        data->qfrc_smooth[i] = u[i] - data->qfrc_bias[i];
    mj_solveM(model, data, a, data->qfrc_smooth, 1);
}
